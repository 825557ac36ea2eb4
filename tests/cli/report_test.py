"""Scans, report and comparison of a small patient. Usage: report_test.py PROGRAM"""
import json
import math
import pathlib
import re
import resource
import shutil
import signal
import tempfile
import time
import unittest

from sanatrix_cli import QUICK, CliTest, main, sanatrix, start, write_patient, stages_run


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
        cls.plan = pathlib.Path(plan)
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


    def test_d_an_interrupted_report_leaves_the_old_one(self):
        self.run_ok("report", self.case)
        stages = self.case / "stages"
        old = {f.name: f.stat().st_mtime_ns for f in (stages / "95-report").iterdir()}
        for number in (signal.SIGINT, signal.SIGTERM):
            drawing = start("report", self.case, "--animations")
            while not list(stages.glob(".95-report.new/frames-*/*.png")):
                self.assertIsNone(drawing.poll(), "finished before it was interrupted")
                time.sleep(0.02)
            drawing.send_signal(number)
            said = drawing.communicate(timeout=60)[1].decode()
            self.assertEqual(drawing.returncode, 5, said)
            self.assertIn("interrupted", said)
            self.assertFalse((stages / ".95-report.new").exists())
            self.assertEqual(
                {f.name: f.stat().st_mtime_ns for f in (stages / "95-report").iterdir()}, old)

    def test_e_landmarks_on_the_scan_place_it(self):
        folder = self.case / "stages/95-report"
        angle, shift = 2.8, (30, -900, 400)
        scan = self.place / "marked.obj"
        turned(folder / "upright_before.obj", scan, angle, shift, 1.0)
        c, s = math.cos(angle), math.sin(angle)

        def on_scan(x, y, z):
            return [x + shift[0], c * y - s * z + shift[1], s * y + c * z + shift[2]]

        bad = self.place / "two.json"
        bad.write_text(json.dumps({"landmarks_scan_mm": {"nipple_L": [0, 0, 0]}}))
        self.run_ok("run", self.case, "--scan", scan, "--set", "outcome.pictures=no")
        self.assertEqual(stages_run(self.case), ["outcome"])  # the model is of the image alone
        truth = json.loads((self.case / "stages/90-outcome/outcome.json").read_text())
        self.assertLess(truth["scans"]["preop"]["model_error"]["whole"]["p95_mm"], 0.3)
        # The vertices farthest forward on each side stand for the nipples.
        points = [tuple(map(float, line.split()[1:4]))
                  for line in (folder / "upright_before.obj").read_text().splitlines()
                  if line.startswith("v ")]
        plan = json.loads(self.plan.read_text())
        plan["sternal_notch_lps_mm"] = max(points, key=lambda p: p[2] - abs(p[0]))
        (self.place / "notch.json").write_text(json.dumps(plan))
        marks = {"sternal_notch": on_scan(*plan["sternal_notch_lps_mm"])}
        for name, side in (("nipple_L", 1), ("nipple_R", -1)):
            breast = [p for p in points if 30 < side * p[0] < 120]
            marks[name] = on_scan(*min(breast, key=lambda p: p[1]))
        good = self.place / "marks.json"
        good.write_text(json.dumps({"landmarks_scan_mm": marks}))
        self.run_ok("run", self.case, "--plan", self.place / "notch.json", "--scan-landmarks", good)
        outcome = json.loads((self.case / "stages/90-outcome/outcome.json").read_text())
        self.assertLess(outcome["scans"]["preop"]["model_error"]["whole"]["p95_mm"], 0.3)
        self.assertTrue(outcome["cosmetics"]["sternal_notch_known"])
        self.refused(2, "run", self.case, "--scan-landmarks", bad, says=["landmarks"])
        self.run_ok("run", self.case, "--scan-landmarks", good)

    def test_f_a_scan_of_two_million_triangles_is_read_in_time_and_memory(self):
        # A bulging sheet 0.5 m wide, 1000 x 1000 squares.
        n = 1000
        with open(self.place / "large.obj", "w") as out:
            for j in range(n + 1):
                for i in range(n + 1):
                    x, z = 500 * i / n - 250, 500 * j / n - 250
                    out.write(f"v {x:.2f} {-150 + (x * x + z * z) / 700:.2f} {z:.2f}\n")
            for j in range(n):
                for i in range(n):
                    a = j * (n + 1) + i + 1
                    out.write(f"f {a} {a + 1} {a + n + 2} {a + n + 1}\n")
        started = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        # Not this patient, or any: read to its end, laid on, and refused with numbers.
        self.refused(2, "run", self.case, "--followup", self.place / "large.obj",
                     says=["cannot be laid onto the patient"])
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - started
        peak_kb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        self.assertLess(used, 60)
        self.assertLess(peak_kb, 3_000_000)


if __name__ == "__main__":
    main()
