#!/usr/bin/python3
"""A patient's stages, each in a process of its own: user seconds, memory, Newton and Krylov counts.

    bench/stages.py [--labels FILE --plan FILE] [--sizes 5,10,50,150] [--reference 10]
    bench/stages.py [--labels FILE --plan FILE] [--sizes 5,10] --against OTHER_SANATRIX [--repeat 3]

Without labels and plan the built-in patient is used. Sizes are thousands of vertices; 5 is
mesh.preset=paper and 10 the default mesh. --reference computes the poses once with P2/P1 elements on
a mesh of that many thousands of vertices and says how far the mean displacement over the volume of
every other row is from it. --against runs another build beside this one, in turns, stage by stage,
and prints the ratio of the user seconds: the only kind of comparison that a busy machine allows.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

from runs import run

STAGES = ["segment", "mesh", "unload", "supine", "surgery", "heal", "upright", "outcome"]
FOLDERS = {"unload": "40-unload", "supine": "50-supine", "upright": "80-upright"}


def mesh_settings(thousands):
    if thousands in (5, 10):
        return [f"mesh.preset={'paper' if thousands == 5 else 'standard'}"]
    factor = (thousands / 10) ** (-1 / 3)  # the default mesh, finer or coarser everywhere
    return [f"mesh.target_vertices={1000 * thousands:.0f}", f"mesh.near_edge_mm={3 * factor:.3f}",
            f"mesh.far_edge_mm={8 * factor:.3f}", "mesh.time_limit_s=3000"]


def knows(binary, key):
    """Older builds have fewer parameters (and draw their pictures)."""
    return key in subprocess.check_output([binary, "params"], text=True)


def make_case(binary, inputs, folder, settings):
    run([binary, "new", folder, "--labels", inputs["labels"], "--plan", inputs["plan"]])
    if knows(binary, "outcome.pictures"):
        settings = [*settings, "outcome.pictures=no"]
    words = [word for setting in settings for word in ("--set", setting)]
    run([binary, "run", folder, *words, "-q", "--to", "segment"])
    return folder


def run_stage(binary, case, stage):
    return run([binary, "run", case, "--from", stage, "--to", stage, "-q"])


def numbers_of(case, stage):
    for folder in (case / "stages").glob(f"*-{stage}"):
        return json.loads((folder / "stage.json").read_text())["numbers"]
    return {}


def count(numbers, kind):
    found = [int(value) for key, value in numbers.items() if key.startswith(f"{kind}_iterations")]
    return str(sum(found)) if found else ""


def measure_size(binary, inputs, thousands, work):
    case = make_case(binary, inputs, work / f"case-{thousands:g}", mesh_settings(thousands))
    rows = []
    for stage in STAGES:
        used = run_stage(binary, case, stage)
        rows.append((stage, used, numbers_of(case, stage)))
        print(f"  {thousands:g} k: {stage} {used[0]:.1f} s", flush=True)
    return {"vertices": int(numbers_of(case, "mesh")["vertices"]), "rows": rows}


def reference_moves(binary, inputs, thousands, work):
    """Mean displacement of every pose by P2/P1 elements: no surgery, no healing."""
    settings = [*mesh_settings(thousands), "solver.element=p2p1", "outcome.pictures=no"]
    case = work / "reference"
    run([binary, "new", case, "--labels", inputs["labels"], "--plan", inputs["plan"]])
    words = [word for setting in settings for word in ("--set", setting)]
    run([binary, "run", case, *words, "-q", "--to", "supine"])
    # Healing one short step leaves the pose before surgery what it is and costs least.
    run([binary, "run", case, "--set", "heal.days=0.5", "-q", "--to", "upright"])
    return {stage: numbers_of(case, stage)["mean_move_mm"] for stage in FOLDERS}


def print_sizes(sizes, reference):
    print("| vertices | stage | user s | wall s | MB | Newton | Krylov | mean move mm "
          "| against P2/P1 |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for size in sizes:
        total = [0.0, 0.0, 0.0]
        for stage, (user, wall, memory), numbers in size["rows"]:
            total = [total[0] + user, total[1] + wall, max(total[2], memory)]
            move = numbers.get("mean_move_mm")
            shown = "" if move is None else f"{move:.3f}"
            error = (f"{100 * (move / reference[stage] - 1):+.2f} %"
                     if move is not None and stage in reference else "")
            print(f"| {size['vertices']:,} | {stage} | {user:.1f} | {wall:.1f} | {memory:.0f} "
                  f"| {count(numbers, 'newton')} | {count(numbers, 'krylov')} | {shown} | {error} |")
        print(f"| {size['vertices']:,} | all | {total[0]:.1f} | {total[1]:.1f} | {total[2]:.0f} "
              "| | | | |", flush=True)


def compare(binaries, inputs, thousands, repeat, work):
    """Both builds, stage by stage in turns."""
    cases = {name: make_case(binary, inputs, work / f"{name}-{thousands:g}",
                             mesh_settings(thousands)) for name, binary in binaries.items()}
    print("| stage | other: user s | this: user s | ratio | other: Newton, Krylov "
          "| this: Newton, Krylov |")
    print("| --- | --- | --- | --- | --- | --- |")
    totals = dict.fromkeys(binaries, 0.0)
    for stage in STAGES:
        used = {name: [] for name in binaries}
        for turn in range(repeat):
            for name in sorted(binaries, reverse=turn % 2 == 1):
                used[name].append(run_stage(binaries[name], cases[name], stage)[0])
        best = {name: statistics.median(times) for name, times in used.items()}
        totals = {name: totals[name] + best[name] for name in binaries}
        counts = {name: ", ".join(filter(None, (count(numbers_of(cases[name], stage), kind)
                                                for kind in ("newton", "krylov"))))
                  for name in binaries}
        print(f"| {stage} | {best['other']:.1f} | {best['this']:.1f} "
              f"| {best['other'] / best['this']:.2f} | {counts['other']} | {counts['this']} |",
              flush=True)
    vertices = {name: int(numbers_of(case, "mesh")["vertices"]) for name, case in cases.items()}
    print(f"| all | {totals['other']:.1f} | {totals['this']:.1f} "
          f"| {totals['other'] / totals['this']:.2f} | {vertices['other']:,} vertices "
          f"| {vertices['this']:,} vertices |")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default="build/release/apps/sanatrix/sanatrix")
    parser.add_argument("--labels", help="label volume (default: the built-in patient's)")
    parser.add_argument("--plan", help="surgical plan (JSON)")
    parser.add_argument("--sizes", default="5,10", help="thousands of vertices")
    parser.add_argument("--reference", type=float, help="P2/P1 poses on this many thousands")
    parser.add_argument("--against", help="another build's sanatrix")
    parser.add_argument("--repeat", type=int, default=1, help="times each stage is run (--against)")
    wanted = parser.parse_args()
    binary = pathlib.Path(wanted.binary).resolve()
    sizes = [float(s) for s in wanted.sizes.split(",") if s]
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        inputs = {"labels": wanted.labels, "plan": wanted.plan}
        if not wanted.labels:
            run([binary, "phantom", work / "phantom", "-q"])
            inputs = {"labels": work / "phantom/labels.nii.gz", "plan": work / "phantom/plan.json"}
        if wanted.against:
            binaries = {"other": pathlib.Path(wanted.against).resolve(), "this": binary}
            for thousands in sizes:
                compare(binaries, inputs, thousands, wanted.repeat, work)
            return
        measured = [measure_size(binary, inputs, thousands, work) for thousands in sizes]
        reference = (reference_moves(binary, inputs, wanted.reference, work)
                     if wanted.reference else {})
        print_sizes(measured, reference)


if __name__ == "__main__":
    main()
