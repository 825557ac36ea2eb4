"""The built-in patient and the way back to its truth. Usage: phantom_test.py PROGRAM"""
import json

from sanatrix_cli import CliTest, main


class Phantom(CliTest):
    def test_round_trip_recovers_the_shapes_that_are_known(self):
        phantom, case = self.folder / "phantom", self.folder / "case"
        truth = json.loads(self.run_ok("phantom", phantom, "--seed", 3, "--volume-cm3", 450,
                                       "--json").stdout)
        self.assertEqual(truth["seed"], 3)
        for name in ["labels.nii.gz", "plan.json", "truth/unloaded.vtu", "truth/unloaded_skin.vtp",
                     "truth/prone_skin.vtp", "truth/supine_skin.vtp", "truth/upright_skin.vtp",
                     "truth/upright_after_skin.vtp"]:
            self.assertTrue((phantom / name).exists(), name)
        self.run_ok("new", case, "--labels", phantom / "labels.nii.gz", "--plan",
                    phantom / "plan.json")
        self.run_ok("run", case, "--set", "mesh.preset=paper", "--set", "heal.days=30")
        score = json.loads(self.run_ok("score", case, phantom, "--json").stdout)
        # Required of the product: 1.5 mm unloaded and 2 mm upright, with another element, mesh and
        # voxelisation between truth and model.
        self.assertLess(score["unloaded"]["mean_mm"], 1.5)
        self.assertLess(score["upright"]["mean_mm"], 2.0)
        # After 30 days the wound is full of cells (0.999 of healthy), which the truth prescribes.
        # Doing nothing would be wrong by all of the true change; a third is asked for.
        self.assertLess(score["upright after surgery"]["mean_mm"], 2.0)
        change = score["change by surgery"]
        self.assertGreater(change["true_max_mm"], 0.5)
        self.assertLess(change["error_mean_mm"], change["true_mean_mm"] / 3)
        self.assertAlmostEqual(change["predicted_max_mm"] / change["true_max_mm"], 1, delta=0.25)
        other = self.scored_with_another_plan(case, phantom)
        self.assertNotIn("change by surgery", other)
        for picture in ["poses.png", "fig4_plan.png", "fig5_species.png", "fig6_volume.png",
                        "fig7_displacement.png"]:
            self.assertTrue((case / "stages/90-outcome" / picture).exists(), picture)
        outcome = json.loads((case / "stages/90-outcome/outcome.json").read_text())
        self.assertFalse([w for w in outcome["warnings"] if "picture" in w])

    def scored_with_another_plan(self, case, phantom):
        """The score when the truth is that of another operation."""
        plan = json.loads((phantom / "plan.json").read_text())
        plan["planned_margin_mm"] += 5
        (phantom / "plan.json").write_text(json.dumps(plan))
        scored = self.run_ok("score", case, phantom, "--json")
        self.assertIn("plan is not the phantom's", scored.stderr)
        return json.loads(scored.stdout)


if __name__ == "__main__":
    main()
