"""A real anatomy whose cells on the chest wall fold when it is unloaded. Usage: real_labels_test.py PROGRAM"""
import json
import os
import pathlib
import unittest

from sanatrix_cli import CliTest, main

LABELS = pathlib.Path(os.environ.get(
    "SANATRIX_SHARED", pathlib.Path(__file__).parents[2] / ".." / "shared")
) / "data/real_prone_labels/Exam_06_detailed.nii.gz"


@unittest.skipUnless(LABELS.is_file(), f"{LABELS} is absent")
class RealLabels(CliTest):
    def test_folding_cells_are_guarded_in_every_pose_and_said(self):
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", LABELS, "--labels-preset", "pelicano")
        done = self.run_ok("run", case, "--to", "supine", "--set", "mesh.preset=paper")
        self.assertIn("cells on the chest wall folded", done.stderr)
        stages = {s: json.loads((case / "stages" / s / "stage.json").read_text())
                  for s in ("40-unload", "50-supine")}
        guard = stages["40-unload"]["numbers"]["wall_guard"]
        self.assertIn(guard, (5.0, 10.0, 20.0))
        self.assertIn(f"guard {guard:g}", stages["40-unload"]["warnings"][0])
        self.assertGreater(stages["50-supine"]["numbers"]["min_jacobian"], 0.1)
        for stage in stages.values():
            self.assertLess(stage["numbers"]["last_residual"], 1e-9)


if __name__ == "__main__":
    main()
