"""sanatrix export: other programs get the model that we solve; CalculiX agrees with the result."""
import json
import os
import pathlib
import shutil
import subprocess
import unittest
import xml.etree.ElementTree as xml

from sanatrix_cli import CliTest, QUICK, block_problem, main, write_block, write_patient

SHARED = pathlib.Path(os.environ.get(
    "SANATRIX_SHARED", pathlib.Path(__file__).parents[2] / ".." / "shared"))


class ExportedFilesSayWhatTheModelIs(CliTest):
    def setUp(self):
        super().setUp()
        write_block(self.folder / "block.msh")
        self.problem = self.folder / "block.json"
        skin = {"law": "veronda_westmann", "alpha": 3940, "beta": 5.03, "c2": -9909.1,
                "thickness": 0.0015, "density": 1100}
        self.problem.write_text(json.dumps(block_problem(skins={"base": skin})))

    def export(self, form, order=1):
        out = self.folder / f"out{order}.{form}"
        told = self.run_ok("export", self.problem, "--format", form, "--order", order,
                           "--out", out, "--json")
        return out, json.loads(told.stdout)

    def test_an_exported_mesh_solves_to_the_same_shape(self):
        _, told = self.export("msh")
        again = next(f for f in told["files"] if f.endswith(".problem.json"))
        results = []
        for number, file in enumerate([self.problem, again]):
            self.run_ok("solve", file, "--out", self.folder / str(number))
            results.append(json.loads((self.folder / str(number) / "result.json").read_text()))
        for key in ["max_displacement_mm", "volume_ratio", "min_jacobian"]:
            self.assertAlmostEqual(results[0][key], results[1][key], delta=1e-9, msg=key)

    def test_febio_files_are_complete(self):
        for order, cell, face in [(1, "tet4", "tri3"), (2, "tet10", "tri6")]:
            out, told = self.export("feb", order)
            root = xml.parse(out).getroot()
            self.assertEqual(root.attrib["version"], "4.0")
            parts = {e.attrib["name"]: e for e in root.find("Mesh").findall("Elements")}
            solids = [e for e in parts.values() if e.attrib["type"] == cell]
            self.assertEqual(sum(len(e) for e in solids), told["cells"])
            self.assertEqual([e.attrib["type"] for n, e in parts.items() if n == "membrane_0"], [face])
            domains = root.find("MeshDomains")
            self.assertEqual({d.attrib["name"] for d in domains}, set(parts))
            self.assertEqual({d.attrib["mat"] for d in domains},
                             {m.attrib["name"] for m in root.find("Material")})
            # FEBio subtracts body forces.
            force = root.find("Loads/body_load/force").text.split(",")
            self.assertEqual([float(f) for f in force], [0, 0, -9.81])
            held = next(iter(root.find("Mesh").findall("NodeSet"))).text.split(",")
            self.assertEqual(len(held), (4 if order == 1 else 7) ** 2)

    def test_abaqus_files_are_complete_and_say_what_is_left_out(self):
        out, told = self.export("inp", 2)
        text = out.read_text()
        self.assertIn("the skin is left out", " ".join(told["notes"]))
        rows = [line for line in text.splitlines() if line.count(",") == 10]
        self.assertEqual(len([r for r in rows if r[0].isdigit()]), told["cells"])
        self.assertIn("*HYPERELASTIC, MOONEY-RIVLIN\n300, 200, 4e-05\n", text)
        self.assertIn("ALL_CELLS, GRAV, 9.81, 0, 0, 1", text)
        for name in ["healthy", "wound"]:
            self.assertIn(f"*SOLID SECTION, ELSET={name},", text)

    def test_vtu_files_hold_every_cell(self):
        out, told = self.export("vtu", 2)
        piece = xml.parse(out).getroot().find("UnstructuredGrid/Piece")
        self.assertEqual(int(piece.attrib["NumberOfCells"]), told["cells"])
        types = piece.find("Cells/DataArray[@Name='types']").text.split()
        self.assertEqual(set(types), {"24"})

    def test_what_cannot_be_exported_is_refused(self):
        self.problem.write_text(json.dumps(block_problem(
            mode="healing", healing={"preset": "vavourakis2016", "wound": ["wound"]})))
        self.refused(2, "export", self.problem, "--format", "feb", says=["healing"])
        labels, plan = write_patient(self.folder / "patient")
        self.run_ok("new", self.folder / "case", "--labels", labels, "--plan", plan)
        self.refused(2, "export", self.folder / "case", "--format", "inp",
                     says=["stress-free", "sanatrix run CASE --to unload"])


@unittest.skipUnless(shutil.which("ccx"), "CalculiX is not installed (apt install calculix-ccx)")
class CalculixAgrees(CliTest):
    """C3D10 is a displacement element, stiffer than our P2/P1 at kappa/mu = 500: 2 % is allowed."""

    def both(self, problem, inp):
        self.run_ok("solve", problem, "--out", self.folder / "ours")
        ours = json.loads((self.folder / "ours/result.json").read_text())
        done = subprocess.run(["ccx", inp.with_suffix("").name], cwd=inp.parent, timeout=1200,
                              capture_output=True, text=True)
        self.assertIn("Job finished", done.stdout, done.stdout[-2000:])
        rows = [line.split() for line in inp.with_suffix(".dat").read_text().splitlines()]
        theirs = [tuple(map(float, row[1:])) for row in rows if len(row) == 4 and row[0].isdigit()]
        self.assertEqual(len(theirs), ours["mesh"]["vertices"])
        return ours, theirs

    def expect_agreement(self, problem, inp, allowed):
        ours, theirs = self.both(problem, inp)
        largest = 1e3 * max(sum(c * c for c in u) ** 0.5 for u in theirs)
        self.assertAlmostEqual(ours["max_displacement_mm"] / largest, 1.0, delta=allowed)
        for i in range(3):
            mean = 1e3 * sum(u[i] for u in theirs) / len(theirs)
            self.assertAlmostEqual(ours["mean_displacement_mm"][i] / largest, mean / largest,
                                   delta=allowed)

    def test_on_the_hemisphere_prone(self):
        mesh = SHARED / "bench/hemiC_v22.msh"
        if not mesh.exists():
            self.skipTest(f"{mesh} is absent")
        law = {"law": "mooney_rivlin", "c1": 150, "c2": 100, "kappa": 2.5e5, "density": 1000}
        problem = self.folder / "hemisphere.json"
        problem.write_text(json.dumps(
            {"mesh": str(mesh.resolve()), "unit": "m", "element": "p2p1", "mode": "forward",
             "gravity": [0, 0, 9.81], "regions": {"breast": law}, "fixed": {"base": "xyz"}}))
        inp = self.folder / "hemisphere.inp"
        self.run_ok("export", problem, "--format", "inp", "--order", "2", "--out", inp)
        self.expect_agreement(problem, inp, 0.01)  # measured: 0.4 %

    def test_on_a_patient_supine(self):
        """Mixed tissues per cell and an anatomical mesh. kappa/mu = 3 keeps C3D10 from locking on
        a mesh this coarse: measured 0.4 % (at 8: 2.4 %, at 400: 9 %, while P2/P1 moves by 4 %)."""
        labels, plan = write_patient(self.folder / "patient")
        case = self.folder / "case"
        soft = [f"tissue.{t}_kappa_pa=3000" for t in ("adipose", "fibroglandular")]
        settings = ["mesh.target_vertices=700", "mesh.near_edge_mm=14", "mesh.far_edge_mm=16",
                    "skin.enabled=no", "tissue.preset=samani2004", *soft]
        self.run_ok("new", case, "--labels", labels, "--plan", plan)
        self.run_ok("run", case, "--to", "unload", *QUICK,
                    *[word for s in settings for word in ("--set", s)])
        exported = [self.folder / "patient.msh", self.folder / "patient.inp"]
        for out in exported:
            self.run_ok("export", case, "--format", out.suffix[1:], "--pose", "supine",
                        "--order", "1" if out.suffix == ".msh" else "2", "--out", out)
        problem = self.folder / "patient.problem.json"
        as_exported = json.loads(problem.read_text())
        self.assertEqual(as_exported["element"], "p1p1")  # the case's own
        problem.write_text(json.dumps({**as_exported, "element": "p2p1"}))
        self.expect_agreement(problem, exported[1], 0.02)


if __name__ == "__main__":
    main()
