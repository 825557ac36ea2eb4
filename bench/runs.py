"""What the benchmark scripts share: a measured process, and a hemisphere under gravity by Gmsh."""
import json
import os
import shutil
import subprocess
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


def run(words, folder=None, threads=2, **more_environment):
    """One process and what it started: (user s, wall s, peak MB of the largest)."""
    env = {**os.environ, "OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": "1",
           **more_environment}
    start = time.monotonic()
    child = subprocess.Popen(list(map(str, words)), cwd=folder, env=env,
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    error = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}: exit code {child.returncode}\n"
                         f"{error.decode(errors='replace')[-500:]}")
    return used.ru_utime, time.monotonic() - start, used.ru_maxrss / 1024


def make_mesh(thousands, folder):
    """A uniform mesh of about so many thousands of vertices."""
    if shutil.which("gmsh") is None:
        raise SystemExit("gmsh is not installed (apt install gmsh)")
    mesh = folder / f"hemisphere-{thousands:g}k.msh"
    if not mesh.exists():
        edge = EDGE_OF_1000_M * thousands ** (-1 / 3)
        geometry = folder / "hemisphere.geo"
        geometry.write_text(GEOMETRY % RADIUS_M)
        run(["gmsh", "-3", geometry, "-clmin", f"{edge}", "-clmax", f"{edge}", "-optimize",
             "-format", "msh22", "-o", mesh], folder, 1)
    return mesh


def write_problem(mesh, element, upright, folder, **more):
    gravity = [0, -9.81, 0] if upright else [0, 0, 9.81]
    problem = folder / f"{mesh.stem}-{element}.json"
    problem.write_text(json.dumps(
        {"mesh": str(mesh), "unit": "m", "element": element, "mode": "forward", "gravity": gravity,
         "regions": {"breast": TISSUE}, "fixed": {"base": "xyz"}, **more}))
    return problem
