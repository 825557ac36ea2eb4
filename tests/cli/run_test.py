"""A small patient through all stages: results, staleness, kills, interrupts, ranks.
Usage: run_test.py PROGRAM"""
import csv
import json
import os
import random
import shutil
import signal
import tempfile
import time
import pathlib

from sanatrix_cli import (QUICK, CliTest, main, outcome_of, sanatrix, stages_run, start,
                          write_patient)

ALL = ["image", "segment", "mesh", "unload", "supine", "surgery", "heal", "upright", "outcome"]


def kill_all_that_name(case):
    """SIGKILL to every process with the case in its command line: launcher, ranks, children."""
    for entry in pathlib.Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0") if entry.name.isdigit() else []
        except OSError:  # it ended meanwhile
            continue
        if str(case).encode() in words:
            os.kill(int(entry.name), signal.SIGKILL)


class Run(CliTest):
    @classmethod
    def setUpClass(cls):
        """One undisturbed run, copied by the tests."""
        cls._shared = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls._shared.name)
        cls.labels, cls.plan = write_patient(folder)
        cls.done = folder / "case"
        assert sanatrix("new", cls.done, "--labels", cls.labels, "--plan", cls.plan).returncode == 0
        cls.first = sanatrix("run", cls.done, "--json", *QUICK)
        assert cls.first.returncode == 0, cls.first.stderr

    @classmethod
    def tearDownClass(cls):
        cls._shared.cleanup()

    def copy(self):
        case = self.folder / "case"
        shutil.copytree(self.done, case)
        return case

    def states(self, case):
        stages = json.loads(self.run_ok("status", case, "--json").stdout)["stages"]
        return {s["name"]: s["state"] for s in stages}

    def test_the_outcome_has_what_is_promised_and_makes_sense(self):
        outcome = json.loads(self.first.stdout)["outcome"]
        self.assertLessEqual(
            {"operated_side", "breast_volume_cm3", "tissue_cm3", "excised_cm3", "excised_percent",
             "wound_volume_ratio_final", "max_displacement_upright_mm",
             "mean_displacement_upright_mm", "min_jacobian", "mesh", "seconds", "warnings"},
            set(outcome))
        self.assertEqual(outcome["operated_side"], "L")
        # Half an ellipsoid and what joins it to the wall: 300 to 650 cm3 a side, both alike.
        left, right = outcome["breast_volume_cm3"]["L"], outcome["breast_volume_cm3"]["R"]
        self.assertTrue(200 < left < 650, left)
        self.assertAlmostEqual(left / right, 1.0, delta=0.05)
        self.assertAlmostEqual(outcome["excised_cm3"] / outcome["excised_exact_cm3"], 1, delta=0.02)
        self.assertTrue(0.85 < outcome["wound_volume_ratio_final"] < 0.99)
        self.assertGreater(outcome["min_jacobian"], 0.1)
        self.assertGreater(outcome["max_displacement_upright_mm"],
                           outcome["mean_displacement_upright_mm"])
        self.assertEqual(set(outcome["seconds"]), set(ALL))

    def test_artefacts_for_people_are_there(self):
        for name in ["30-mesh/prone.vtu", "40-unload/unloaded.vtu", "50-supine/supine.vtu",
                     "60-surgery/wound.vtu", "60-surgery/incision.vtp", "70-heal/healing.pvd",
                     "70-heal/history.csv", "80-upright/upright_after_skin.vtp",
                     "90-outcome/tissue_table.csv", "90-outcome/skin_displacement.vtp"]:
            self.assertTrue((self.done / "stages" / name).exists(), name)
        pvd = (self.done / "stages/70-heal/healing.pvd").read_text()
        self.assertEqual(pvd.count("<DataSet"), 5)  # days 0, 6, 12, 18, 24
        self.assertTrue((self.done / "run.log").read_text().splitlines()[0].count("sanatrix"))

    def test_a_fresh_case_is_left_alone(self):
        case = self.copy()
        self.run_ok("run", case)
        self.assertEqual(stages_run(case), [])

    def test_a_changed_margin_redoes_surgery_to_outcome_only(self):
        case = self.copy()
        self.run_ok("run", case, "--set", "surgery.margin_mm=11")
        self.assertEqual(stages_run(case), ALL[5:])
        self.assertGreater(outcome_of(case)["excised_cm3"], outcome_of(self.done)["excised_cm3"])
        self.run_ok("run", case, "--plan", self.plan)  # back to the plan as it was
        # Newton's method started from the other plan's shapes; where it ends is the same.
        self.numbers_agree(case, ["excised_cm3", "wound_volume_ratio_final", "min_jacobian",
                                  "max_displacement_upright_mm", "mean_displacement_upright_mm"])

    def test_parameters_make_exactly_their_stages_stale(self):
        case = self.copy()
        self.run_ok("run", case, "--set", "heal.days=12", "--to", "mesh")
        states = self.states(case)
        self.assertEqual([name for name in ALL if states[name] == "stale"], ALL[6:])
        self.run_ok("run", case, "--set", "heal.days=24", "--to", "mesh")
        self.assertEqual(set(self.states(case).values()), {"fresh"})
        self.run_ok("run", case, "--from", "surgery", "--to", "surgery")
        self.assertEqual(stages_run(case), ["surgery"])

    def test_a_failed_stage_keeps_the_last_good_result(self):
        case = self.copy()
        bad = json.loads(self.plan.read_text())
        bad["tumour"]["centre_lps_mm"] = [200.0, -8.0, 8.0]  # beside the patient
        (self.folder / "bad.json").write_text(json.dumps(bad))
        self.refused(2, "run", case, "--plan", self.folder / "bad.json")
        self.assertTrue((case / "stages/60-surgery/wound.vtu").exists())
        self.run_ok("run", case, "--plan", self.plan)
        self.assertEqual(outcome_of(case), outcome_of(self.done))

    def test_without_a_plan_everything_else_is_computed(self):
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", self.labels)
        self.refused(2, "run", case, *QUICK, says=["surgery", "no surgical plan", "--plan"])
        states = self.states(case)
        self.assertEqual({states[name] for name in ALL[:5] + ["upright"]}, {"fresh"})
        self.assertEqual(states["surgery"], "failed")

    def test_killed_runs_resume_to_the_same_result(self):
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", self.labels, "--plan", self.plan)
        moments = random.Random(4)
        for _ in range(6):
            process = start("run", case, *QUICK)
            time.sleep(moments.uniform(0.2, 6.0))
            process.kill()
            process.communicate()
        self.run_ok("run", case, *QUICK)
        self.assertEqual(outcome_of(case), outcome_of(self.done))
        leftovers = [p.name for p in (case / "stages").iterdir() if p.name.startswith(".")]
        self.assertEqual(leftovers, [])

    def test_ctrl_c_checkpoints_healing_and_ends_with_5(self):
        case = self.copy()
        process = start("run", case, "--from", "heal", "-q")
        checkpoint = case / "stages/.70-heal.new/checkpoint.bin"
        while not checkpoint.exists():
            self.assertIsNone(process.poll(), "healing ended before it could be interrupted")
            time.sleep(0.01)
        process.send_signal(signal.SIGSTOP)  # on a busy machine healing would end meanwhile
        self.refused(4, "run", case, says=["in use by process"])
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGCONT)
        _, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 5, stderr)
        self.assertIn(b"interrupted", stderr)
        self.run_ok("run", case, "--from", "heal")
        self.assertEqual(outcome_of(case), outcome_of(self.done))

    def history(self, case):
        with open(case / "stages/70-heal/history.csv", newline="") as file:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]

    def numbers_agree(self, case, keys):
        one, several = outcome_of(self.done), outcome_of(case)
        for key in keys:
            self.assertAlmostEqual(one[key] / several[key], 1.0, delta=1e-8, msg=key)

    def test_ranks_share_the_mesh_and_give_the_same_numbers(self):
        for ranks in (2, 4):  # three: below
            with self.subTest(ranks=ranks):
                case = self.copy()
                self.run_ok("run", case, "--from", "unload", "--ranks", ranks)
                self.assertEqual(stages_run(case), ALL[3:])
                self.numbers_agree(case, ["wound_volume_ratio_final", "max_displacement_upright_mm",
                                          "mean_displacement_upright_mm", "min_jacobian"])
                for stage in ["40-unload", "50-supine", "70-heal", "80-upright"]:
                    numbers = json.loads((case / "stages" / stage / "stage.json").read_text())["numbers"]
                    self.assertEqual(numbers["ranks"], ranks)
                    self.assertLess(numbers["most_own_vertices"] + numbers["most_ghost_vertices"],
                                    numbers["vertices"], stage)
                for one, several in zip(self.history(self.done), self.history(case), strict=True):
                    for key, value in one.items():
                        # Species: nine digits are written. Shapes on the way are solved to 1e-5.
                        delta = 1e-8 if "_mean" in key or "_centre" in key else 1e-4
                        self.assertAlmostEqual(value, several[key], delta=delta, msg=key)
                shutil.rmtree(case)

    def test_taylor_hood_shares_its_mid_edge_nodes_too(self):
        moves = []
        for ranks in (1, 2):
            case = self.copy()
            self.run_ok("run", case, "--to", "supine", "--ranks", ranks,
                        "--set", "solver.element=p2p1", "--set", "skin.enabled=no")
            record = json.loads((case / "stages/50-supine/stage.json").read_text())
            moves.append(record["numbers"]["mean_move_mm"])
            shutil.rmtree(case)
        self.assertAlmostEqual(moves[0] / moves[1], 1.0, delta=1e-8)

    def test_killed_on_some_ranks_it_goes_on_with_others(self):
        for before, after in ((2, 1), (1, 3)):
            with self.subTest(before=before, after=after):
                case = self.copy()
                process = start("run", case, "--from", "heal", "--ranks", before, "-q")
                checkpoint = case / "stages/.70-heal.new/checkpoint.bin"
                while not checkpoint.exists():
                    self.assertIsNone(process.poll(), "healing ended before it could be killed")
                    time.sleep(0.01)
                kill_all_that_name(case)
                process.communicate()
                resumed = self.run_ok("run", case, "--from", "heal", "-v", "--ranks", after)
                self.numbers_agree(case, ["wound_volume_ratio_final", "max_displacement_upright_mm",
                                          "min_jacobian"])
                steps = resumed.stderr.count("[H] heal: load 100 %, Newton 0")
                self.assertIn(steps, range(1, 5),
                              "24 days have five mechanics steps; some were done")
                shutil.rmtree(case)

    def test_an_error_ends_all_ranks_with_its_exit_code(self):
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", self.labels)
        self.refused(2, "run", case, "--to", "surgery", "--ranks", "2", *QUICK,
                     says=["no surgical plan"])


if __name__ == "__main__":
    main()
