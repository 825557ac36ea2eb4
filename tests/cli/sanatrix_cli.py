"""Helpers of the command line tests: running the program, a small patient, a small mesh."""
import gzip
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

# One thread: the problems are small, and the machine is shared with other tests.
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
BINARY = ""

# A patient small and coarse enough for tests; pictures have their own tests.
QUICK = ["--set", "mesh.target_vertices=1500", "--set", "mesh.near_edge_mm=8",
         "--set", "segment.spacing_mm=2", "--set", "heal.days=24", "--set", "outcome.pictures=no"]


def main():
    """Runs the tests of the calling file; argv[1] is the program."""
    global BINARY
    BINARY = sys.argv.pop(1)
    unittest.main(module="__main__", verbosity=2)


def binary():
    return BINARY


def sanatrix(*words, timeout=900):
    """Runs the command to its end."""
    return subprocess.run([BINARY, *map(str, words)], capture_output=True, text=True,
                          timeout=timeout, env=ENVIRONMENT, stdin=subprocess.DEVNULL)


def start(*words):
    """Starts the command without waiting."""
    return subprocess.Popen([BINARY, *map(str, words)], stdout=subprocess.DEVNULL,
                            stderr=subprocess.PIPE, env=ENVIRONMENT, stdin=subprocess.DEVNULL)


class CliTest(unittest.TestCase):
    """Each test has an empty folder and says what a failing command printed."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = pathlib.Path(self._folder.name)

    def run_ok(self, *words, **options):
        done = sanatrix(*words, **options)
        self.assertEqual(done.returncode, 0, f"{words}\n{done.stdout}\n{done.stderr}")
        return done

    def refused(self, exit_code, *words, says=()):
        """The command ends with this code and one line on stderr that says all of these."""
        done = sanatrix(*words)
        self.assertEqual(done.returncode, exit_code, f"{words}\n{done.stdout}\n{done.stderr}")
        last = done.stderr.strip().splitlines()[-1]
        self.assertTrue(last.startswith("sanatrix: error: "), done.stderr)
        for text in says:
            self.assertIn(text, last)
        return last


def outcome_of(case):
    """outcome.json without the clock."""
    outcome = json.loads((case / "stages/90-outcome/outcome.json").read_text())
    del outcome["seconds"]
    return outcome


def stages_run(case):
    """Names of the stages that the last run worked on."""
    names = []
    for line in (case / "run.jsonl").read_text().splitlines():
        event = json.loads(line)
        if event["event"] == "begin":
            names = []
        elif event["event"] == "started":
            names.append(event["stage"])
    return names


# --- a patient of simple shapes: a curved chest wall and two ellipsoidal breasts, prone, LPS ---------

TUMOUR = (70.0, -8.0, 8.0)
TUMOUR_RADIUS = 7.0


def _label(x, y, z):
    front = 200.0 - math.sqrt(180.0**2 - x * x)
    if y > front:
        return 4 if y - front < 10.0 else 6
    side = 1.0 if x > 0 else -1.0
    r = math.hypot((x - side * 62.0) / 46.0, (y - 17.0) / 62.0, z / 50.0)
    if r > 1.0 and y < front - 14.0:
        return 0
    if math.dist((x, y, z), TUMOUR) < TUMOUR_RADIUS:
        return 8
    if 0.955 < r <= 1.0 and y < front - 14.0:
        return 3
    return 2 if r < 0.5 else 1


def write_nifti(path, size, spacing, origin, voxels):
    """Unsigned bytes; origin in LPS millimetres (NIfTI itself is RAS)."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *size, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, spacing, spacing, spacing, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    struct.pack_into("<f", header, 112, 1)
    struct.pack_into("<B", header, 123, 2)
    struct.pack_into("<hh", header, 252, 0, 1)
    struct.pack_into("<4f", header, 280, -spacing, 0, 0, -origin[0])
    struct.pack_into("<4f", header, 296, 0, -spacing, 0, -origin[1])
    struct.pack_into("<4f", header, 312, 0, 0, spacing, origin[2])
    header[344:348] = b"n+1\0"
    with gzip.open(path, "wb") as file:
        file.write(bytes(header) + voxels)


def write_patient(folder, change=lambda label: label):
    """labels.nii.gz and plan.json of a small patient; `change` maps labels, to spoil them."""
    folder.mkdir(parents=True, exist_ok=True)
    spacing, origin, size = 2.0, (-128.0, -60.0, -84.0), (129, 60, 85)
    voxels = bytes(change(_label(origin[0] + spacing * i, origin[1] + spacing * j,
                                 origin[2] + spacing * k))
                   for k in range(size[2]) for j in range(size[1]) for i in range(size[0]))
    write_nifti(folder / "labels.nii.gz", size, spacing, origin, voxels)
    plan = {"operated_side": "L", "quadrant": "upper outer", "midline_x_mm": 0.0,
            "coordinates": "LPS mm, PRONE", "planned_margin_mm": 8.0,
            "tumour": {"centre_lps_mm": TUMOUR, "equivalent_radius_mm": TUMOUR_RADIUS}}
    (folder / "plan.json").write_text(json.dumps(plan))
    return folder / "labels.nii.gz", folder / "plan.json"


# --- a block of tetrahedra with a cube inside that can be the wound ---------------------------------

def write_block(path, cells=3, edge=0.01):
    """Gmsh 2.2: volumes healthy and wound (the middle cube), surfaces base (z = 0) and
    sides (smallest and largest x), point top."""
    n = cells + 1
    number = {(i, j, k): 1 + i + n * (j + n * k)
              for k in range(n) for j in range(n) for i in range(n)}
    # Kuhn's six tetrahedra of a cube: one for each order in which the axes are walked.
    orders = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    elements = [f"15 2 4 4 {number[cells, cells, cells]}"]
    middle = cells // 2
    for k in range(cells):
        for j in range(cells):
            for i in range(cells):
                region = 2 if (i, j, k) == (middle, middle, middle) else 1
                for order in orders:
                    corner = [i, j, k]
                    walk = [number[tuple(corner)]]
                    for axis in order:
                        corner[axis] += 1
                        walk.append(number[tuple(corner)])
                    elements.append(f"4 2 {region} {region} {' '.join(map(str, walk))}")
    for j in range(cells):
        for i in range(cells):
            a, b = number[i, j, 0], number[i + 1, j, 0]
            c, d = number[i + 1, j + 1, 0], number[i, j + 1, 0]
            elements += [f"2 2 3 3 {a} {c} {b}", f"2 2 3 3 {a} {d} {c}"]
    for k in range(cells):
        for j in range(cells):
            for i in (0, cells):
                a, b = number[i, j, k], number[i, j + 1, k]
                c, d = number[i, j + 1, k + 1], number[i, j, k + 1]
                elements += [f"2 2 5 5 {a} {b} {c}", f"2 2 5 5 {a} {c} {d}"]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "5", '3 1 "healthy"',
             '3 2 "wound"', '2 3 "base"', '0 4 "top"', '2 5 "sides"', "$EndPhysicalNames",
             "$Nodes", str(len(number))]
    lines += [f"{v} {i * edge} {j * edge} {k * edge}" for (i, j, k), v in number.items()]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{e + 1} {text}" for e, text in enumerate(elements)]
    path.write_text("\n".join(lines + ["$EndElements", ""]))


def block_problem(**changes):
    law = {"law": "mooney_rivlin", "c1": 300, "c2": 200, "kappa": 5e4, "density": 1000}
    problem = {"mesh": "block.msh", "unit": "m", "element": "p1p1", "mode": "forward",
               "regions": {"healthy": law, "wound": dict(law)}, "fixed": {"base": "xyz"},
               "gravity": [0, 0, 9.81]}
    problem.update(changes)
    return problem
