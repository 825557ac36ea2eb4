#!/usr/bin/python3
"""Counts and times of `sanatrix solve --ranks N` on a hemisphere under gravity.

    bench/scaling.py --counts 36 --ranks 1,2,4,8,16,32,64     Newton, Krylov, ghosts, messages
    bench/scaling.py --times 36 --per-rank 18                  strong and weak scaling, 1 and 2 ranks

Sizes are thousands of vertices. Counts hold on any machine: more ranks than cores only take longer.
Messages and bytes are those of PETSc's own log over the whole solve (mesh distribution included).
"""
import argparse
import json
import pathlib
import re
import tempfile

from runs import make_mesh, run, write_problem

SKIN = {"skin": {"law": "veronda_westmann", "alpha": 3940, "beta": 5.03, "c2": -9909.1,
                 "thickness": 0.0015, "density": 1100, "tension_field": True}}


def solve(binary, problem, ranks, folder):
    """(result.json, PETSc's log, used) of one solve."""
    out = folder / f"out-{ranks}"
    log = folder / f"log-{ranks}.txt"
    words = [binary, "solve", problem, "--out", out, "-q"]
    words += ["--ranks", ranks] if ranks > 1 else []
    used = run(words, folder, 1, PETSC_OPTIONS=f"-log_view :{log}")
    return json.loads((out / "result.json").read_text()), log.read_text(), used


def logged(log, name):
    """Largest, mean and total over ranks of a line of PETSc's summary."""
    found = re.search(rf"^{name}\s+(\S+)\s+\S+\s+(\S+)(?:\s+(\S+))?", log, re.MULTILINE)
    return [float(value) if value else 0.0 for value in found.groups()] if found else [0.0] * 3


def print_counts(binary, thousands, all_ranks, skin, upright, folder):
    problem = write_problem(make_mesh(thousands, folder), "p1p1", upright, folder,
                            **({"skins": SKIN} if skin else {}))
    print("| ranks | Newton | Krylov | most own vertices | most ghosts | mean ghosts | c "
          "| messages, most of a rank | MB sent, most of a rank | largest difference |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    first = None
    for ranks in all_ranks:
        result, log, _ = solve(binary, problem, ranks, folder)
        first = first or result
        spread = result.get("distribution", {})
        own = result["mesh"]["vertices"] / ranks
        mean_ghosts = spread.get("mean_ghost_vertices", 0)
        difference = max(abs(a - b) for a, b in zip(result["volume_mean_displacement_mm"],
                                                    first["volume_mean_displacement_mm"]))
        difference /= first["max_displacement_mm"]
        print(f"| {ranks} | {result['newton_iterations']} | {result['krylov_iterations']} "
              f"| {spread.get('most_own_vertices', own):.0f} "
              f"| {spread.get('most_ghost_vertices', 0):.0f} | {mean_ghosts:.0f} "
              f"| {mean_ghosts / own ** (2 / 3):.1f} | {logged(log, 'MPI Msg Count:')[0]:.0f} "
              f"| {logged(log, r'MPI Msg Len [(]bytes[)]:')[0] / 1e6:.2f} | {difference:.0e} |",
              flush=True)


def print_times(binary, strong, weak, folder):
    """Each on an otherwise idle machine, or compare user seconds only."""
    print("| scaling | ranks | vertices | assembly s | linear s | Newton | Krylov | wall s |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for kind, sizes in (("strong", {1: strong, 2: strong}), ("weak", {1: weak, 2: 2 * weak})):
        for ranks, thousands in sizes.items():
            problem = write_problem(make_mesh(thousands, folder), "p1p1", False, folder)
            result, _, used = solve(binary, problem, ranks, folder)
            print(f"| {kind} | {ranks} | {result['mesh']['vertices']:,} "
                  f"| {result['seconds']['assembly']:.2f} | {result['seconds']['linear']:.2f} "
                  f"| {result['newton_iterations']} | {result['krylov_iterations']} "
                  f"| {used[1]:.1f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default="build/release/apps/sanatrix/sanatrix")
    parser.add_argument("--counts", type=float, help="thousands of vertices")
    parser.add_argument("--ranks", default="1,2,4,8,16,32,64")
    parser.add_argument("--skin", action="store_true", help="--counts with a membrane skin")
    parser.add_argument("--upright", action="store_true", help="--counts with gravity along the base")
    parser.add_argument("--times", type=float, help="thousands of vertices of strong scaling")
    parser.add_argument("--per-rank", type=float, default=18, help="the same of weak scaling")
    wanted = parser.parse_args()
    binary = pathlib.Path(wanted.binary).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if wanted.counts:
            print_counts(binary, wanted.counts, [int(n) for n in wanted.ranks.split(",")],
                         wanted.skin, wanted.upright, folder)
        if wanted.times:
            print_times(binary, wanted.times, wanted.per_rank, folder)


if __name__ == "__main__":
    main()
