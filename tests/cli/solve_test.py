"""sanatrix solve on a block of tetrahedra: results, refusals, ranks. Usage: solve_test.py PROGRAM"""
import csv
import json

from sanatrix_cli import CliTest, block_problem, main, write_block


class Solve(CliTest):
    def setUp(self):
        super().setUp()
        write_block(self.folder / "block.msh")

    def problem(self, **changes):
        file = self.folder / "problem.json"
        file.write_text(json.dumps(block_problem(**changes)))
        return file

    def solve(self, *words, **changes):
        out = self.folder / "out"
        self.run_ok("solve", self.problem(**changes), "--out", out, *words)
        return json.loads((out / "result.json").read_text())

    def test_forward_stretches_a_hanging_block(self):
        result = self.solve()
        self.assertLessEqual({"converged", "newton_iterations", "krylov_iterations",
                              "max_displacement_mm", "mean_displacement_mm", "volume_ratio",
                              "min_jacobian", "probes", "seconds", "peak_memory_mb"}, set(result))
        self.assertIs(result["converged"], True)
        # rho g L^2 / (2 E) = 0.1 .. 0.2 mm per E = 6 (c1 + c2) = 3 kPa and L = 30 mm: order of 1 mm.
        self.assertTrue(0.3 < result["probes"]["top"][2] < 3.0, result["probes"])
        self.assertAlmostEqual(result["volume_ratio"], 1.0, delta=0.01)
        self.assertTrue((self.folder / "out/result.vtu").exists())

    def test_inverse_shortens_it(self):
        self.assertLess(self.solve(mode="inverse")["probes"]["top"][2], -0.3)

    def test_millimetres_and_metres_agree(self):
        metre = self.solve()
        write_block(self.folder / "block.msh", edge=10)
        self.assertAlmostEqual(self.solve(unit="mm")["max_displacement_mm"],
                               metre["max_displacement_mm"], delta=1e-9)

    def test_taylor_hood_and_a_skin_solve_too(self):
        soft = self.solve(element="p2p1")["max_displacement_mm"]
        skin = {"base": {"law": "veronda_westmann", "alpha": 3940, "beta": 5.03, "c2": -9909.1,
                         "thickness": 0.0015, "density": 1100, "tension_field": True}}
        self.assertAlmostEqual(self.solve(element="p2p1", skins=skin)["max_displacement_mm"], soft,
                               delta=1e-3 * soft)  # the base is fixed: its skin does nothing

    def test_ranks_share_the_mesh_and_agree_to_1e_8(self):
        skin = {"sides": {"law": "veronda_westmann", "alpha": 3940, "beta": 5.03, "c2": -9909.1,
                          "thickness": 0.0015}}
        for changes in ({}, {"element": "p2p1"}, {"mode": "inverse"}, {"skins": skin},
                        {"element": "smoothed", "skins": skin},
                        {"element": "smoothed", "mode": "inverse"}):
            with self.subTest(changes=changes):
                one = self.solve(**changes)
                two = self.solve("--ranks", "3", **changes)
                for a, b in zip([*one["mean_displacement_mm"], *one["volume_mean_displacement_mm"], *one["probes"]["top"],
                                 one["max_displacement_mm"], one["min_jacobian"]],
                                [*two["mean_displacement_mm"], *two["volume_mean_displacement_mm"], *two["probes"]["top"],
                                 two["max_displacement_mm"], two["min_jacobian"]]):
                    self.assertAlmostEqual(a, b, delta=1e-8 * one["max_displacement_mm"])
                self.assertEqual(one["mesh"], two["mesh"])
        pieces = (self.folder / "out/result.pvtu").read_text()
        for rank in range(3):
            self.assertIn(f"result_{rank:04d}.vtu", pieces)
            self.assertTrue((self.folder / f"out/result_{rank:04d}.vtu").exists())

    def heal(self, *words, **changes):
        """Result and rows of history.csv."""
        healing = {"preset": "vavourakis2016", "wound": ["wound"], "days": 24,
                   "mechanics_interval_days": 6, **changes}
        problem = block_problem(mode="healing", healing=healing)
        del problem["gravity"]
        (self.folder / "heal.json").write_text(json.dumps(problem))
        out = self.folder / "out"
        self.run_ok("solve", self.folder / "heal.json", "--out", out, *words)
        with open(out / "history.csv", newline="") as file:
            rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
        return json.loads((out / "result.json").read_text()), rows

    def test_healing_contracts_the_wound(self):
        _, rows = self.heal(scheme="cvode")
        self.assertLessEqual({"t_day", "eta_mean", "eta_centre", "nu_mean", "xi_mean", "zeta_mean",
                              "mu_mean", "V_over_V0", "wall_displacement_mm"}, set(rows[0]))
        self.assertEqual(rows[0]["V_over_V0"], 1.0)
        self.assertLess(rows[-1]["V_over_V0"], 0.99)
        self.assertEqual(rows[-1]["t_day"], 24.0)

    def test_healing_on_shares_agrees_to_1e_8(self):
        for scheme in ({"scheme": "cvode"}, {"scheme": "explicit", "dt_s": 1000.0}):
            one, history = self.heal(**scheme)
            for ranks in ("2", "3"):
                with self.subTest(ranks=ranks, **scheme):
                    several, shared = self.heal("--ranks", ranks, **scheme)
                    for key in ["wound_volume_ratio_final", "max_displacement_mm", "min_jacobian",
                                "volume_ratio"]:
                        self.assertAlmostEqual(one[key] / several[key], 1.0, delta=1e-8, msg=key)
                    self.assertEqual(several["distribution"]["ranks"], int(ranks))
                    self.assertEqual(len(history), len(shared))
                    for a, b in zip(history, shared):
                        for key in a:  # nine digits are written, of numbers up to 24
                            self.assertAlmostEqual(a[key], b[key], delta=2e-8, msg=key)

    def test_mistakes_are_named_with_what_there_is(self):
        good = block_problem()["regions"]
        out = ("--out", self.folder / "out")
        cases = [({"colour": "red"}, ["colour", "regions"]),
                 ({"regions": {**good, "tail": good["wound"]}}, ["tail", "healthy", "wound"]),
                 ({"regions": {"healthy": good["healthy"]}}, ["wound", "no law"]),
                 ({"regions": {**good, "wound": {"law": "steel"}}}, ["mooney_rivlin"]),
                 ({"regions": {**good, "wound": {**good["wound"], "c1": "soft"}}}, ["c1", "number"]),
                 ({"fixed": {"roof": "xyz"}}, ["roof", "base"]),
                 ({"fixed": {"base": "up"}}, ["base", "x, y"]),
                 ({"gravity": [0, 0]}, ["gravity"]),
                 ({"unit": "inch"}, ["inch", "mm"]),
                 ({"mode": "magic"}, ["magic", "inverse"]),
                 ({"mesh": "absent.msh"}, ["absent.msh"]),
                 ({"mode": "healing"}, ["healing"])]
        for changes, says in cases:
            with self.subTest(changes=changes):
                self.refused(2, "solve", self.problem(**changes), *out, says=says)
        (self.folder / "problem.json").write_text("{")
        self.refused(2, "solve", self.folder / "problem.json", *out, says=["JSON"])

    def test_no_convergence_is_not_mistaken_for_success(self):
        self.solve()  # an older success in the same folder
        soft = {"law": "mooney_rivlin", "c1": 1e-4, "c2": 0, "kappa": 1, "density": 1000}
        line = self.refused(3, "solve", self.problem(regions={"healthy": soft, "wound": soft}),
                            "--out", self.folder / "out")
        self.assertIn("load", line)
        result = json.loads((self.folder / "out/result.json").read_text())
        self.assertIs(result["converged"], False)


if __name__ == "__main__":
    main()
