"""Making cases: what is taken in and what is refused, with words. Usage: new_test.py PROGRAM"""
import json

from sanatrix_cli import CliTest, main, write_patient


class New(CliTest):
    def test_a_case_keeps_inputs_under_neutral_names_with_hashes(self):
        labels, plan = write_patient(self.folder / "Jane Doe")
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", labels, "--plan", plan)
        head = json.loads((case / "case.json").read_text())
        self.assertEqual(head["inputs"]["labels"]["file"], "inputs/labels.nii.gz")
        self.assertEqual(len(head["inputs"]["plan"]["sha256"]), 64)
        for file in [case / "case.json", *case.glob("*.log")]:
            self.assertNotIn("Doe", file.read_text())
        states = {s["state"] for s in json.loads(self.run_ok("status", case, "--json").stdout)["stages"]}
        self.assertEqual(states, {"missing"})

    def test_bad_inputs_leave_no_case_behind(self):
        labels, plan = write_patient(self.folder)
        case = self.folder / "case"
        text = self.folder / "notes.nii.gz"
        text.write_text("not an image")
        broken = self.folder / "broken.json"
        broken.write_text('{"operated_side": "L"')
        self.refused(2, "new", case, "--labels", self.folder / "absent.nii.gz")
        self.refused(2, "new", case, "--labels", text)
        self.refused(2, "new", case, "--labels", labels, "--plan", broken)
        self.refused(1, "new", case, "--labels", labels, "--labels-preset", "other",
                     says=["sanatrix", "pelicano"])
        self.refused(1, "new", case)
        self.assertFalse(case.exists())
        self.assertEqual(list(self.folder.glob(".case*")), [])

    def test_a_plan_for_the_other_side_is_refused(self):
        labels, plan = write_patient(self.folder)
        wrong = json.loads(plan.read_text())
        wrong["operated_side"] = "R"
        plan.write_text(json.dumps(wrong))
        self.refused(2, "new", self.folder / "case", "--labels", labels, "--plan", plan)

    def test_an_existing_case_is_not_overwritten(self):
        labels, _ = write_patient(self.folder)
        self.run_ok("new", self.folder / "case", "--labels", labels)
        before = (self.folder / "case/case.json").read_bytes()
        self.refused(2, "new", self.folder / "case", "--labels", labels, says=["exists"])
        self.assertEqual((self.folder / "case/case.json").read_bytes(), before)

    def test_parameters_are_checked_before_anything_runs(self):
        labels, _ = write_patient(self.folder)
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", labels)
        before = (case / "case.json").read_bytes()
        self.refused(1, "run", case, "--set", "mesh.colour=red", says=["mesh.target_vertices"])
        self.refused(1, "run", case, "--set", "nonsense")
        self.refused(1, "run", case, "--to", "moon", says=["upright"])
        self.refused(1, "run", case, "--from", "heal", "--to", "mesh", says=["order"])
        self.refused(2, "run", case, "--set", "heal.days=never")
        self.refused(2, "run", case, "--set", "heal.days=-1")
        self.refused(2, "run", case, "--set", "heal.preset=wishful", says=["vavourakis2016"])
        self.refused(2, "run", case, "--set", "tissue.preset=wood", says=["vavourakis2016"])
        self.refused(2, "run", case, "--set", "heal.days=30", "--set", "solver.element=p9")
        self.assertEqual((case / "case.json").read_bytes(), before)

    def test_labels_that_are_no_prone_breasts_are_refused_by_the_run(self):
        for spoil, name in [(lambda l: 1 if l >= 4 and l < 8 else l, "no wall"),
                            (lambda l: 0 if l < 4 or l == 8 else l, "no breast")]:
            labels, _ = write_patient(self.folder / name, spoil)
            case = self.folder / name / "case"
            self.run_ok("new", case, "--labels", labels)
            self.refused(2, "run", case, says=["segment"])
            stages = json.loads(self.run_ok("status", case, "--json").stdout)["stages"]
            self.assertEqual([s["state"] for s in stages[:3]], ["fresh", "failed", "missing"])

    def test_a_mesh_that_takes_too_long_is_given_up(self):
        labels, plan = write_patient(self.folder / "patient")
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", labels, "--plan", plan)
        # A million vertices take minutes; the harness's own limit tells an end from a hang.
        self.refused(4, "run", case, "--to", "mesh", "--set", "segment.spacing_mm=2",
                     "--set", "mesh.target_vertices=1000000", "--set", "mesh.near_edge_mm=1.5",
                     "--set", "mesh.time_limit_s=2", says=["meshing took longer than 2 s", " - "])


if __name__ == "__main__":
    main()
