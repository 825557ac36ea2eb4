"""Scans, report and comparison of a small patient. Usage: report_test.py PROGRAM"""
import json
import math
import pathlib
import re
import shutil
import tempfile
import unittest

from sanatrix_cli import QUICK, CliTest, main, sanatrix, write_patient


def turned(source, target, angle, shift, scale):
    """Copies an OBJ with its companions, turned about x, shifted and in another unit."""
    c, s = math.cos(angle), math.sin(angle)
    lines = []
    for line in source.read_text().splitlines():
        if line.startswith("v "):
            x, y, z = (float(word) for word in line.split()[1:])
            x, y, z = x + shift[0], c * y - s * z + shift[1], s * y + c * z + shift[2]
            line = f"v {scale * x:.6f} {scale * y:.6f} {scale * z:.6f}"
        lines.append(line)
    target.write_text("\n".join(lines) + "\n")
    for extension in (".mtl", ".jpg"):
        shutil.copy(source.with_suffix(extension), target.parent)


class Report(CliTest):
    @classmethod
    def setUpClass(cls):
        cls._shared = tempfile.TemporaryDirectory()
        cls.place = pathlib.Path(cls._shared.name)
        labels, plan = write_patient(cls.place)
        cls.case = cls.place / "case"
        made = sanatrix("new", cls.case, "--labels", labels, "--plan", plan)
        done = sanatrix("run", cls.case, *QUICK)
        assert made.returncode == 0 and done.returncode == 0, made.stderr + done.stderr

    @classmethod
    def tearDownClass(cls):
        cls._shared.cleanup()

    def test_a_case_is_reported_and_its_own_surfaces_come_back_as_scans(self):
        written = json.loads(self.run_ok("report", self.case, "--json").stdout)
        folder = pathlib.Path(written["folder"])
        self.assertEqual(written["files"][0], "report.html")
        html = (folder / "report.html").read_text()
        for text in ("patient&#39;s", "LEFT", "Research use only", "BRA", "Pezner", "SHA-256"):
            self.assertTrue(text in html or text.replace("&#39;", "'") in html, text)
        self.assertNotIn("<script", html)
        self.assertEqual(re.findall(r"(?:src|href)=[\"'](?!data:)", html), [])
        self.assertNotIn(str(self.place), html)
        self.assertEqual((folder / "upright.glb").read_bytes()[:4], b"glTF")

        # The prediction itself as a follow-up scan, in another pose and unit: nothing is left.
        scan, later = self.place / "before.obj", self.place / "after.obj"
        turned(folder / "upright_before.obj", scan, 0.7, (30, -900, 400), 0.1)
        turned(folder / "upright_after.obj", later, -0.4, (-10, 50, 1200), 1.0)
        self.run_ok("run", self.case, "--scan", scan, "--followup", later)
        outcome = json.loads((self.case / "stages/90-outcome/outcome.json").read_text())
        scans = outcome["scans"]
        self.assertEqual((scans["preop"]["unit"], scans["followup"]["unit"]), ("cm", "mm"))
        self.assertLess(scans["followup"]["table1"]["operated_breast"]["p95_mm"], 0.3)
        self.assertLess(scans["preop"]["model_error"]["both_breasts"]["p95_mm"], 0.3)
        predicted = {m["key"]: m for m in outcome["cosmetics"]["metrics"]}["retraction_mm"]["change"]
        seen = scans["observed_retraction"]["operated_breast"]["depth_mm"]
        self.assertAlmostEqual(seen, predicted, delta=0.3)
        self.run_ok("report", self.case)
        self.assertIn("Against the follow-up scan", (folder / "report.html").read_text())

    def test_b_bad_scans_change_nothing(self):
        before = (self.case / "case.json").read_bytes()
        bad = self.place / "bad.obj"
        bad.write_text("mtllib absent.mtl\nv 0 0 0\nv 400 0 0\nv 400 400 0\nf 1 2 3\n")
        self.refused(2, "run", self.case, "--scan", bad, says=["absent.mtl", "missing"])
        self.refused(2, "run", self.case, "--followup", self.place / "none.obj", says=["none.obj"])
        self.assertEqual((self.case / "case.json").read_bytes(), before)

    def test_c_cases_are_compared_and_unfinished_ones_refused(self):
        other = self.place / "other"
        shutil.copytree(self.case, other)
        page = self.place / "both.html"
        self.run_ok("compare", self.case, other, "--out", page)
        self.assertIn("other", page.read_text())
        self.refused(1, "compare", self.case)
        (other / "stages/90-outcome/outcome.json").unlink()
        self.refused(2, "report", other, says=["outcome", "sanatrix run"])


if __name__ == "__main__":
    main()
