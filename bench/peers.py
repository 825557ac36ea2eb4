#!/usr/bin/python3
"""Whole solves of a hemisphere under gravity, by mesh size and element, beside CalculiX.

    bench/peers.py [--binary SANATRIX] [--sizes 5,10,50,150] [--calculix 0.7] [--upright]

Every row is one process: user seconds, wall seconds, peak memory, Newton and Krylov counts, and the
error of the mean displacement against P2/P1 on the finest mesh that it is affordable on. Sizes are
thousands of vertices of uniform meshes made here by Gmsh. A reference kernel (a fixed
piece of work of the same program) is timed in the same run, so that rows of different days and
machines can be compared by their ratio to it.
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

RADIUS_M = 0.065
GEOMETRY = """SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, %g, 0, Pi/2, 2*Pi};
Physical Volume("breast") = {1};
Physical Surface("skin") = {1};
Physical Surface("base") = {2};
"""
TISSUE = {"law": "mooney_rivlin", "c1": 150, "c2": 100, "kappa": 2.5e5, "density": 1000}
# Edge length that gives a thousand vertices, found by trial; the count grows with its inverse cube.
EDGE_OF_1000_M = 0.0079
# User seconds on the quiet two-core machine of the recorded runs (shared/bench/README.md), the
# mesh of 4.6 k vertices: prone, upright.
RECORDED = [("FEBio 4, tet10 three-field, 22 k cells", 93, 584),
            ("FEBio 4, tet10 displacement, 22 k cells", 70, 182),
            ("CalculiX 2.20, C3D10, 22 k cells", 721, None),
            ("FEniCSx 0.5, P2/P1, 22 k cells", 194, 432)]


def run(words, folder, threads):
    """One process: (user s, wall s, peak MB)."""
    env = {**os.environ, "OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": "1"}
    start = time.monotonic()
    child = subprocess.Popen(words, cwd=folder, env=env, stdout=subprocess.DEVNULL,
                             stderr=subprocess.PIPE)
    error = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}: exit code {child.returncode}\n"
                         f"{error.decode(errors='replace')[-500:]}")
    return used.ru_utime, time.monotonic() - start, used.ru_maxrss / 1024


def make_mesh(thousands, folder):
    mesh = folder / f"hemisphere-{thousands:g}k.msh"
    if not mesh.exists():
        edge = EDGE_OF_1000_M * thousands ** (-1 / 3)
        geometry = folder / "hemisphere.geo"
        geometry.write_text(GEOMETRY % RADIUS_M)
        run(["gmsh", "-3", geometry, "-clmin", f"{edge}", "-clmax", f"{edge}", "-optimize",
             "-format", "msh22", "-o", mesh], folder, 1)
    return mesh


def write_problem(mesh, element, upright, folder):
    gravity = [0, -9.81, 0] if upright else [0, 0, 9.81]
    problem = folder / f"{mesh.stem}-{element}.json"
    problem.write_text(json.dumps(
        {"mesh": mesh.name, "unit": "m", "element": element, "mode": "forward", "gravity": gravity,
         "regions": {"breast": TISSUE}, "fixed": {"base": "xyz"}}))
    return problem


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


def print_table(rows, reference, kernel_s):
    print("| system | vertices | user s | wall s | MB | Newton | Krylov | mean mm | error | kernels |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for row in sorted(rows, key=lambda r: (r["name"], r["vertices"])):
        user, wall, memory = row["used"]
        error = row["mean"] / reference - 1
        print(f"| {row['name']} | {row['vertices']} | {user:.1f} | {wall:.1f} | {memory:.0f} "
              f"| {row['newton'] or ''} | {row['krylov'] or ''} | {row['mean']:.3f} "
              f"| {100 * error:+.1f} % | {user / kernel_s:.1f} |")


def print_time_to_accuracy(rows, reference, allowed=0.02):
    for name in sorted({row["name"] for row in rows}):
        good = [row for row in rows if row["name"] == name
                and abs(row["mean"] / reference - 1) <= allowed]
        best = min(good, key=lambda r: r["used"][0], default=None)
        said = (f"{best['used'][0]:.1f} user s ({best['vertices']} vertices)" if best
                else "not reached")
        print(f"time to {100 * allowed:.0f} % error of the mean displacement, {name}: {said}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default="build/release/apps/sanatrix/sanatrix")
    parser.add_argument("--sizes", default="5,10,50", help="thousands of vertices, P1/P1")
    parser.add_argument("--taylor-hood", default="0.7,5", help="thousands of vertices, P2/P1")
    parser.add_argument("--calculix", default="0.7", help="thousands of vertices, C3D10")
    parser.add_argument("--upright", action="store_true", help="gravity along the base")
    wanted = parser.parse_args()
    if shutil.which("gmsh") is None:
        raise SystemExit("bench/peers.py: gmsh is not installed (apt install gmsh)")
    binary = pathlib.Path(wanted.binary).resolve()

    def sizes(text):
        return [float(s) for s in text.split(",") if s]

    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        kernel_s = solve(binary, make_mesh(2, folder), "p1p1", False, folder)["used"][0]
        rows = [solve(binary, make_mesh(k, folder), "p1p1", wanted.upright, folder)
                for k in sizes(wanted.sizes)]
        rows += [solve(binary, make_mesh(k, folder), "p2p1", wanted.upright, folder)
                 for k in sizes(wanted.taylor_hood)]
        reference = max((r for r in rows if r["name"].endswith("p2p1")),
                        key=lambda r: r["vertices"], default=rows[-1])["mean"]
        if shutil.which("ccx"):
            rows += [calculix(binary, make_mesh(k, folder), wanted.upright, folder)
                     for k in sizes(wanted.calculix)]
        else:
            print("CalculiX is left out: not installed (apt install calculix-ccx)")
    print(f"reference kernel (P1/P1, 2 k vertices, prone, one process): {kernel_s:.2f} user s")
    print_table(rows, reference, kernel_s)
    print_time_to_accuracy(rows, reference)
    print("recorded elsewhere, not in this run, user s:")
    for name, prone, upright in RECORDED:
        shown = upright if wanted.upright else prone
        if shown is not None:
            print(f"  {name}: {shown}")


if __name__ == "__main__":
    main()
