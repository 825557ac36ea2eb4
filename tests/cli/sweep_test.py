"""sanatrix sweep on this machine: every task once, whatever is killed."""
import csv
import json
import os
import pathlib
import random
import signal
import tempfile
import time

from sanatrix_cli import CliTest, QUICK, main, sanatrix, start, write_patient


def workers_of(driver):
    """Process ids of the driver's children."""
    found = []
    for status in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            pid, rest = status.read_text().split(" ", 1)
            if int(rest.rpartition(")")[2].split()[1]) == driver:
                found.append(int(pid))
        except (OSError, ValueError, IndexError):
            pass
    return found


class ASweep(CliTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls._shared = tempfile.TemporaryDirectory()
        cls.home = pathlib.Path(cls._shared.name)
        labels, cls.plan = write_patient(cls.home / "patient")
        cls.case = cls.home / "case"
        for words in [("new", cls.case, "--labels", labels, "--plan", cls.plan),
                      ("run", cls.case, "--to", "supine", *QUICK, "--set", "heal.days=12")]:
            done = sanatrix(*words)
            assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls._shared.cleanup()

    def sweep(self, **content):
        file = self.folder / "sweep.json"
        file.write_text(json.dumps({"case": str(self.case), **content}))
        return file

    def rows(self):
        with open(self.folder / "sweep.sweep/results.csv") as file:
            return list(csv.DictReader(file))

    def test_a_grid_has_every_combination_once_and_runs_only_once(self):
        bad = json.loads(self.plan.read_text())
        bad["tumour"]["centre_lps_mm"] = [200.0, -8.0, 8.0]  # beside the patient
        (self.folder / "bad.json").write_text(json.dumps(bad))
        file = self.sweep(plans=[str(self.plan), "bad.json"],
                          parameters={"surgery.margin_mm": [7, 9, 7]})
        self.run_ok("sweep", file, "-q")
        rows = self.rows()
        self.assertEqual([(r["status"], r["surgery.margin_mm"]) for r in rows],
                         [("ok", "7"), ("ok", "9"), ("failed", "7"), ("failed", "9")])
        self.assertIn("surgery", rows[2]["error"])
        self.assertGreater(float(rows[1]["excised_cm3"]), float(rows[0]["excised_cm3"]))
        files = {p: p.stat().st_mtime_ns for p in (self.folder / "sweep.sweep/results").iterdir()}
        self.assertEqual(len(files), 4)
        self.run_ok("sweep", file, "-q")
        self.assertEqual({p: p.stat().st_mtime_ns for p in files}, files)
        # A task is exactly what `run` computes.
        case = self.folder / "alone"
        self.run_ok("new", case, "--labels", self.home / "patient/labels.nii.gz", "--plan", self.plan)
        self.run_ok("run", case, "-q", *QUICK, "--set", "heal.days=12", "--set", "surgery.margin_mm=9")
        outcome = json.loads((case / "stages/90-outcome/outcome.json").read_text())
        self.assertEqual(float(rows[1]["max_displacement_upright_mm"]),
                         outcome["max_displacement_upright_mm"])

    def test_latin_hypercube_samples_fill_their_strata_and_repeat(self):
        file = self.sweep(parameters={"surgery.margin_mm": {"from": 6, "to": 10}},
                          sampling="latin_hypercube", samples=2, seed=5)
        self.run_ok("sweep", file, "-q")
        margins = sorted(float(r["surgery.margin_mm"]) for r in self.rows())
        self.assertTrue(6 < margins[0] < 8 < margins[1] < 10, margins)
        before = (self.folder / "sweep.sweep/results.csv").read_bytes()
        self.run_ok("sweep", file, "-q")
        self.assertEqual((self.folder / "sweep.sweep/results.csv").read_bytes(), before)

    def test_killed_drivers_and_workers_lose_and_double_nothing(self):
        file = self.sweep(parameters={"surgery.margin_mm": [6.5, 7.5, 8.5],
                                      "heal.days": [6, 12]})
        moments = random.Random(7)
        for _ in range(3):
            driver = start("sweep", file, "-q")
            time.sleep(moments.uniform(1.0, 4.0))
            for worker in workers_of(driver.pid):
                os.kill(worker, signal.SIGKILL)
            time.sleep(moments.uniform(0.5, 2.0))
            driver.kill()  # its new workers live on and meet those of the next driver
            driver.communicate()
        self.run_ok("sweep", file, "-q")
        rows = self.rows()
        self.assertEqual([r["status"] for r in rows], ["ok"] * 6)
        self.assertEqual(len({r["task"] for r in rows}), 6)
        results = self.folder / "sweep.sweep/results"
        self.assertEqual({p.stem for p in results.iterdir()}, {r["task"] for r in rows})
        # An undisturbed sweep has the same numbers.
        disturbed = (self.folder / "sweep.sweep/results.csv").read_bytes()
        self.run_ok("sweep", file, "-q", "--out", self.folder / "again")
        self.assertEqual((self.folder / "again/results.csv").read_bytes(), disturbed)

    def test_what_is_wrong_is_named(self):
        self.refused(2, "sweep", self.sweep(parameters={"surgery.margin_mm": 7}), says=["margin_mm"])
        self.refused(1, "sweep", self.sweep(parameters={"surgery.margn": [7]}), says=["margn"])
        self.refused(2, "sweep", self.sweep(parameters={"surgery.margin_mm": [700]}), says=["700"])
        self.refused(2, "sweep", self.sweep(plans=["none.json"]), says=["none.json"])
        self.refused(2, "sweep", self.sweep(colour=1), says=["colour"])


if __name__ == "__main__":
    main()
