#!/usr/bin/python3
"""Whole solves of a hemisphere under gravity, by mesh and element, beside CalculiX, in one run.

    bench/peers.py [--binary SANATRIX] [--pose prone|upright|both] [--sizes 2,3,50] [--calculix 0.7]

Every row is one process: user seconds, wall seconds, peak memory, Newton and Krylov counts, and the
error of the mean displacement over the volume against P2/P1. Sizes are thousands of vertices of
uniform meshes made here by Gmsh. With the recorded meshes (SANATRIX_SHARED/bench) all elements also
solve the very tetrahedra that other programs were recorded with. Their seconds are brought to the
machine and load of this run by a reference kernel: CalculiX on the small recorded mesh, whose
seconds were recorded too.
"""
import argparse
import json
import os
import pathlib
import shutil
import tempfile

from runs import make_mesh, run, write_problem

POSES = ["prone", "upright"]
ALLOWED = {"prone": 0.02, "upright": 0.04}  # error that still counts as the answer
# User seconds recorded on the mesh of 4.6 k vertices (shared/bench/README.md).
RECORDED = {"FEBio 4, tet10 three-field": {"prone": 93, "upright": 584},
            "FEBio 4, tet10 displacement": {"prone": 70, "upright": 182},
            "FEniCSx 0.5, P2/P1": {"prone": 194, "upright": 432},
            "CalculiX 2.20, C3D10": {"prone": 721}}
KERNEL_S = {"prone": 8.4, "upright": 31}  # recorded: CalculiX C3D10, mesh of 0.7 k vertices


def solve(binary, mesh, element, upright, folder):
    problem = write_problem(mesh, element, upright, folder)
    used = run([binary, "solve", problem, "--out", problem.with_suffix("")], folder, 2)
    result = json.loads((problem.with_suffix("") / "result.json").read_text())
    return {"name": f"sanatrix {element}", "vertices": result["mesh"]["vertices"], "used": used,
            "newton": result["newton_iterations"], "krylov": result["krylov_iterations"],
            "mean": result["volume_mean_displacement_mm"][1 if upright else 2]}


def volume_mean(model, moves):
    """int u dV / V of values at the corners of the cells of an Abaqus file."""
    points, weights, reading = {}, {}, ""
    for line in model.read_text().splitlines():
        if line.startswith("*"):
            reading = line.upper()
        elif reading.startswith("*NODE,"):
            number, *position = line.split(",")
            points[int(number)] = tuple(map(float, position))
        elif reading.startswith("*ELEMENT") and "C3D10" in reading:
            corners = list(map(int, line.split(",")[1:5]))
            o, *others = (points[c] for c in corners)
            a, b, c = ([q - w for q, w in zip(p, o)] for p in others)
            det = (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                   + a[2] * (b[0] * c[1] - b[1] * c[0]))
            for corner in corners:
                weights[corner] = weights.get(corner, 0.0) + abs(det) / 24
    return sum(w * moves[n] for n, w in weights.items()) / sum(weights.values())


def calculix(binary, mesh, upright, folder):
    problem = write_problem(mesh, "p2p1", upright, folder)
    model = folder / f"calculix-{mesh.stem}.inp"
    run([binary, "export", problem, "--format", "inp", "--order", "2", "--out", model], folder, 2)
    used = run(["ccx", model.stem], folder, 2)
    rows = [line.split() for line in model.with_suffix(".dat").read_text().splitlines()]
    moves = {int(row[0]): 1e3 * float(row[2 if upright else 3]) for row in rows
             if len(row) == 4 and row[0].isdigit()}
    return {"name": "CalculiX C3D10", "vertices": len(moves), "used": used, "newton": None,
            "krylov": None, "mean": volume_mean(model, moves)}


def print_table(rows, reference):
    print("| system | vertices | user s | wall s | MB | Newton | Krylov | mean mm | error |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for row in sorted(rows, key=lambda r: (r["name"], r["vertices"])):
        user, wall, memory = row["used"]
        error = row["mean"] / reference - 1
        print(f"| {row['name']} | {row['vertices']:,} | {user:.1f} | {wall:.1f} | {memory:.0f} "
              f"| {row['newton'] or ''} | {row['krylov'] or ''} | {row['mean']:.3f} "
              f"| {100 * error:+.1f} % |")


def print_time_to_accuracy(rows, reference, allowed):
    for name in sorted({row["name"] for row in rows}):
        good = [row for row in rows if row["name"] == name
                and abs(row["mean"] / reference - 1) <= allowed]
        best = min(good, key=lambda r: r["used"][0], default=None)
        said = (f"{best['used'][0]:.2f} user s ({best['vertices']:,} vertices)" if best
                else "not reached")
        print(f"time to {100 * allowed:.0f} % error of the mean displacement, {name}: {said}")


def print_recorded(pose, same_tets, kernel):
    """Recorded peers, slowed down as much as the reference kernel was, against our rows."""
    slow = kernel["used"][0] / KERNEL_S[pose]
    print(f"reference kernel (CalculiX, 0.7 k vertices): {kernel['used'][0]:.1f} user s, recorded "
          f"{KERNEL_S[pose]} s: this run is {slow:.2f} times slower")
    print("| recorded, same tetrahedra | recorded s | on this run's terms | / P1/P1 | / smoothed "
          "| / P2/P1 |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, seconds in RECORDED.items():
        if pose in seconds:
            here = slow * seconds[pose]
            ratios = " | ".join(f"{here / row['used'][0]:.0f}" if here > 100 * row["used"][0]
                                else f"{here / row['used'][0]:.1f}" for row in same_tets)
            print(f"| {name} | {seconds[pose]} | {here:.0f} | {ratios} |")


def measure(binary, pose, wanted, recorded, folder):
    upright = pose == "upright"
    has_peer = shutil.which("ccx") is not None
    same_tets = []
    if recorded:
        same_tets = [solve(binary, recorded / "hemi5k_v22.msh", element, upright, folder)
                     for element in ("p1p1", "smoothed", "p2p1")]
    rows = [solve(binary, make_mesh(k, folder), "p1p1", upright, folder) for k in wanted["sizes"]]
    rows += [solve(binary, make_mesh(k, folder), element, upright, folder)
             for k in wanted["taylor_hood"] for element in ("smoothed", "p2p1")]
    kernel = (calculix(binary, recorded / "hemiC_v22.msh", upright, folder)
              if recorded and has_peer else None)
    peers = ([calculix(binary, make_mesh(k, folder), upright, folder)
              for k in wanted["calculix"]] if has_peer else [])
    reference = max((r for r in same_tets + rows if r["name"].endswith("p2p1")),
                    key=lambda r: r["vertices"], default=(same_tets + rows)[-1])["mean"]
    rows += same_tets + peers + ([kernel] if kernel else [])
    print(f"\n## {pose}\n", flush=True)
    print_table(rows, reference)
    print_time_to_accuracy(rows, reference, ALLOWED[pose])
    if kernel:
        print_recorded(pose, same_tets, kernel)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default="build/release/apps/sanatrix/sanatrix")
    parser.add_argument("--pose", choices=[*POSES, "both"], default="both")
    parser.add_argument("--sizes", default="2,3", help="thousands of vertices, P1/P1")
    parser.add_argument("--taylor-hood", default="0.7", help="thousands of vertices, P2/P1 and smoothed")
    parser.add_argument("--calculix", default="", help="thousands of vertices, C3D10")
    given = parser.parse_args()
    binary = pathlib.Path(given.binary).resolve()
    wanted = {key: [float(s) for s in getattr(given, key).split(",") if s]
              for key in ("sizes", "taylor_hood", "calculix")}
    shared = pathlib.Path(os.environ.get("SANATRIX_SHARED", "../shared")).resolve() / "bench"
    if not shared.exists():
        print("the recorded meshes are not there (SANATRIX_SHARED): no comparison on them")
    if shutil.which("ccx") is None:
        print("CalculiX is left out: not installed (apt install calculix-ccx)")
    with tempfile.TemporaryDirectory() as name:
        for pose in POSES if given.pose == "both" else [given.pose]:
            measure(binary, pose, wanted, shared if shared.exists() else None,
                    pathlib.Path(name))


if __name__ == "__main__":
    main()
