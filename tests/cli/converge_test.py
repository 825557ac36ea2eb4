"""sanatrix converge: a small patient on three meshes; about 30 s of one core."""
import json
import pathlib
import tempfile
import xml.etree.ElementTree as xml

from sanatrix_cli import CliTest, QUICK, main, sanatrix, stages_run, write_patient


class Converge(CliTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls._shared = tempfile.TemporaryDirectory()
        cls.home = pathlib.Path(cls._shared.name)
        cls.labels, plan = write_patient(cls.home)
        cls.case = cls.home / "case"
        for words in [("new", cls.case, "--labels", cls.labels, "--plan", plan),
                      ("run", cls.case, *QUICK, "-q")]:
            done = sanatrix(*words)
            assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls._shared.cleanup()

    def test_table_json_and_plot_of_a_study_that_goes_on(self):
        words = ["converge", self.case, "--sizes", "1500,2600,4200", "--intervals", "12,6",
                 "--json", "-q"]
        study = json.loads(self.run_ok(*words).stdout)
        out = self.home / "case.convergence"
        self.assertEqual(study, json.loads((out / "convergence.json").read_text()))
        vertices = [run["vertices"] for run in study["by_mesh"]]
        self.assertEqual(vertices, sorted(vertices))
        own = json.loads((self.case / "stages/90-outcome/outcome.json").read_text())
        self.assertEqual(own["mesh"]["vertices"], vertices[0])  # the case's own mesh is one of them
        for output in study["outputs"]:
            values = [run["values"][output["key"]] for run in study["by_mesh"]]
            self.assertEqual(values[0], own[output["key"]])
            self.assertEqual(values[-1], output["finest"])
            # The two finest meshes cannot differ by more than the bar at order 2 allows.
            edge = (vertices[-1] / vertices[-2]) ** (1 / 3)
            self.assertGreaterEqual(output["error_bar"] * (1 + 1e-9),
                                    1.25 * abs(values[-1] - values[-2]) / (edge ** 2 - 1))
        by_days = {run["mechanics_interval_days"]: run["values"] for run in study["by_interval"]}
        self.assertEqual(by_days[6.0], study["by_mesh"][0]["values"])
        self.assertNotEqual(by_days[12.0], by_days[6.0])
        self.assertTrue(xml.parse(out / "convergence.svg").getroot().tag.endswith("svg"))
        self.assertIn("order", (out / "convergence.txt").read_text())
        # What is there is not made again, and the case itself was left alone.
        made = {file: file.stat().st_mtime_ns for file in (out / "runs/results").iterdir()}
        self.assertEqual(len(made), 4)
        self.run_ok(*words)
        self.assertEqual(made, {f: f.stat().st_mtime_ns for f in (out / "runs/results").iterdir()})
        self.assertIn("outcome", stages_run(self.case))

    def test_what_cannot_be_studied_is_said(self):
        self.refused(1, "converge", self.case, "--sizes", "1500,2600", says=["three meshes"])
        self.refused(2, "converge", self.folder / "absent")
        self.run_ok("new", self.folder / "planless", "--labels", self.labels)
        self.refused(2, "converge", self.folder / "planless", says=["plan"])


if __name__ == "__main__":
    main()
