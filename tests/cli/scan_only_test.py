"""From a surface scan alone to the outcome. Usage: scan_only_test.py PROGRAM"""
import base64
import json
import math

from sanatrix_cli import CliTest, QUICK, main, outcome_of


def skin(x, z, rise=50.0):
    """y [mm] of an elliptic trunk with two breasts, upper poles longer than lower ones."""
    chest = 100 - 100 * math.sqrt(1 - (x / 160) ** 2)
    across, along = (abs(x) - 85) / 36, z / (52 if z > 0 else 30)
    return chest - rise * math.exp(-0.5 * (across ** 2 + along ** 2))


AREOLAS = [(-78.0, -12.0), (90.0, -8.0)]  # x, z [mm], off the tips of the breasts


def colour(x, z):
    """Vertex colours 0..1 of skin with two areolas."""
    near = min(math.hypot(x - a, z - b) for a, b in AREOLAS)
    return "0.55 0.31 0.27" if near < 17 else "0.85 0.68 0.58"


def write_scan(path, unit=1.0, rise=50.0, coloured=False, keep=lambda x, z: True, extra=""):
    """As a camera delivers it: x left, y up, z to the front; `unit` in millimetres."""
    nx, nz, h = 61, 65, 5.0
    points, faces = [], []
    for k in range(nz):
        for i in range(nx):
            x, z = h * (i - nx // 2), h * (k - nz // 2)
            points.append((x / unit, (z + 1200) / unit, -skin(x, z, rise) / unit,
                           colour(x, z) if coloured else ""))
            if i + 1 < nx and k + 1 < nz and keep(x, z):
                a = k * nx + i
                faces += [(a, a + 1, a + nx), (a + 1, a + nx + 1, a + nx)]
    text = extra + "".join(f"v {x:.4f} {y:.4f} {z:.4f} {c}\n" for x, y, z, c in points)
    path.write_text(text + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces))


# A PNG of one grey pixel.
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNoaGgAAAMEAYFL09IQAAAA"
    "AElFTkSuQmCC")
PLAN = {"operated_side": "L", "planned_margin_mm": 8,
        "tumour": {"clock": "1:30", "from_nipple_mm": 25, "depth_mm": 22, "diameter_mm": 12}}


class ScanOnly(CliTest):
    def test_a_scan_in_centimetres_goes_to_the_outcome(self):
        scan, plan, case = (self.folder / name for name in ["torso.obj", "plan.json", "case"])
        write_scan(scan, unit=10.0)
        plan.write_text(json.dumps(PLAN))
        made = self.run_ok("new", case, "--scan", scan, "--pose", "upright", "--density", "c",
                           "--plan", plan)
        self.assertIn("scan in cm", made.stdout)
        self.run_ok("run", case, *QUICK)
        outcome = outcome_of(case)
        # Made of the scan, she must stand as in the scan again: 5 mm columns of the scan, elements
        # of about 10 mm over a radius of 40 mm (sagitta 0.3 mm), labels of 2 mm.
        self.assertLess(outcome["scans"]["preop"]["model_error"]["both_breasts"]["mean_mm"], 1.0)
        # The piece is laid on the table around the tumour that came along, not bent from standing.
        carried_out = json.loads((case / "stages/60-surgery/plan.json").read_text())
        self.assertEqual(carried_out["frame"], "supine")
        given = json.loads(next((case / "inputs").glob("plan*.json")).read_text())
        self.assertGreater(math.dist(carried_out["tumour"]["centre_lps_mm"],
                                     given["tumour"]["centre_lps_mm"]), 5)
        estimate = outcome["scan_only"]
        self.assertTrue(estimate["chest_wall"]["estimated"])
        self.assertGreater(estimate["breast_volume_doubt_cm3"]["L"], 10)  # 4 mm over its base
        self.assertTrue([w for w in outcome["warnings"] if "chest wall is estimated" in w])
        # All of the breast, and nothing else, is the mixture.
        tissue = outcome["tissue_cm3"]["L"]
        self.assertAlmostEqual(tissue["fibroglandular"] / outcome["breast_volume_cm3"]["L"], 0.35,
                               delta=0.04)
        # Mirrored trunk: both sides alike.
        volume = outcome["breast_volume_cm3"]
        self.assertLess(abs(volume["L"] - volume["R"]), 0.06 * volume["L"])
        placed = json.loads(next((case / "inputs").glob("plan-*.json")).read_text())
        x, y, z = placed["tumour"]["centre_lps_mm"]
        self.assertEqual(placed["frame"], "upright")
        nipple = json.loads(next((case / "inputs").glob("scan_frame-*.json")).read_text())
        left = nipple["nipple_lps_mm"]["L"]
        self.assertGreater(x, left[0])  # half past one of the left breast: up and out
        self.assertGreater(z, left[2])
        self.assertGreater(y, left[1])

    def test_the_chest_wall_gives_a_range(self):
        scan, plan, case = (self.folder / name for name in ["torso.obj", "plan.json", "case"])
        write_scan(scan)
        plan.write_text(json.dumps(PLAN))
        self.run_ok("new", case, "--scan", scan, "--pose", "upright", "--plan", plan)
        self.run_ok("run", case, *QUICK)
        alone = outcome_of(case)
        healed = (case / "stages/70-heal/stage.json").read_bytes()
        self.assertIsNone(alone["wall_range"])
        self.assertTrue([w for w in alone["warnings"] if "outcome.wall_range=yes" in w])
        made = self.run_ok("run", case, "--set", "outcome.wall_range=yes")
        self.assertIn("chest wall +-7 mm", made.stdout)
        outcome = outcome_of(case)
        # Only the outcome is made anew, and its own numbers stay.
        self.assertEqual((case / "stages/70-heal/stage.json").read_bytes(), healed)
        key = "mean_displacement_upright_mm"
        self.assertEqual(outcome[key], alone[key])
        wall = outcome["wall_range"]
        self.assertEqual(wall["failed"], {})
        self.assertLessEqual(wall[key]["low"], alone[key])
        self.assertLess(wall[key]["low"], wall[key]["high"])
        # 7 mm up and down over a base of at least one deviation of the bump, 36 by 41 mm on average:
        # pi 3.6 4.1 1.4 = 65 cm3.
        volume = wall["breast_volume_cm3"]["L"]
        self.assertGreater(volume["high"] - volume["low"], 65)
        self.assertLess(volume["low"], outcome["breast_volume_cm3"]["L"])
        self.assertGreater(volume["high"], outcome["breast_volume_cm3"]["L"])

    def frame(self, case):
        name = json.loads((case / "case.json").read_text())["inputs"]["scan_frame"]["file"]
        return json.loads((case / name).read_text())

    def test_areolas_in_inches_and_landmarks_given_later(self):
        scan, plan, case, marks = (self.folder / name for name in
                                   ["torso.obj", "plan.json", "case", "marks.json"])
        write_scan(scan, unit=25.4, coloured=True)
        plan.write_text(json.dumps(PLAN))
        made = self.run_ok("new", case, "--scan", scan, "--pose", "upright", "--plan", plan)
        self.assertIn("scan in in;", made.stdout)
        frame = self.frame(case)
        places = frame["nipple_lps_mm"]
        apart = math.dist(places["R"], places["L"])
        (x0, z0), (x1, z1) = AREOLAS
        true = math.dist((x0, skin(x0, z0), z0), (x1, skin(x1, z1), z1))
        self.assertAlmostEqual(apart, true, delta=5.0)  # half a column of the scan per side
        self.assertEqual({find["from"] for find in frame["nipples"].values()}, {"colour"})
        # Marks win, and the plan, which is given from the nipple, moves along.
        x, z = 100.0, 5.0
        marks.write_text(json.dumps({"landmarks_scan_mm": {
            "nipple_L": [x, z + 1200, -skin(x, z)]}}))
        before = json.loads((case / "case.json").read_text())["inputs"]["plan"]
        self.run_ok("run", case, "--landmarks", marks, "--to", "image", *QUICK)
        self.assertEqual(self.frame(case)["nipples"]["L"]["from"], "mark")
        self.assertNotEqual(json.loads((case / "case.json").read_text())["inputs"]["plan"], before)

    def test_scans_that_cannot_be_used(self):
        scan, case = self.folder / "torso.obj", self.folder / "case"
        words = ["new", case, "--scan", scan, "--pose", "upright"]
        scan.write_text("")
        self.refused(2, *words, says=["no faces"])
        write_scan(scan, unit=1000.0)
        self.refused(2, *words, "--scan-unit", "mm", says=["in mm", "--scan-unit"])
        write_scan(scan, keep=lambda x, z: x > 0)  # one side only
        self.refused(2, *words, says=["breast"])
        # A face on an edge that two have already: read, not refused.
        write_scan(scan, coloured=True)
        scan.write_text(scan.read_text() + "v 0 1200 -60\nf 1900 1901 3966\n")
        self.run_ok(*words)

    def test_bad_input_is_told_in_a_line(self):
        scan, case = self.folder / "torso.obj", self.folder / "case"
        write_scan(scan)
        self.refused(1, "new", case, "--scan", scan, says=["--pose upright"])
        flat = self.folder / "flat.obj"
        write_scan(flat, rise=3.0)
        self.refused(2, "new", case, "--scan", flat, "--pose", "upright", says=["no two breasts"])
        prone = self.folder / "prone.json"
        prone.write_text(json.dumps({"operated_side": "L", "tumour": {
            "centre_lps_mm": [80, 0, 0], "equivalent_radius_mm": 6}}))
        self.refused(2, "new", case, "--scan", scan, "--pose", "upright", "--plan", prone,
                     says=["prone", "standing scan"])
        silent = self.folder / "nowhere.json"
        silent.write_text(json.dumps({**PLAN, "tumour": {"from_nipple_mm": 30, "depth_mm": 20,
                                                         "diameter_mm": 12}}))
        self.refused(2, "new", case, "--scan", scan, "--pose", "upright", "--plan", silent,
                     says=["tumour.clock"])
        self.assertFalse(case.exists())

    def test_left_and_right_that_contradict_each_other(self):
        scan, case = self.folder / "torso.obj", self.folder / "case"
        write_scan(scan)
        words = ["new", case, "--scan", scan, "--pose", "upright"]
        marks, plan = self.folder / "marks.json", self.folder / "plan.json"

        def mark(**at):
            marks.write_text(json.dumps({"landmarks_scan_mm": {
                name: [x, z + 1200, -skin(x, z)] for name, (x, z) in at.items()}}))
            return [*words, "--landmarks", marks]

        self.refused(2, *mark(nipple_L=(-85, 0)), says=["nipple_L lies on the patient's right"])
        self.refused(2, *mark(nipple_L=(-85, 0), nipple_R=(85, 0), sternal_notch=(0, 150)),
                     says=["look backwards", "mirrored"])
        marks.write_text(json.dumps({"landmarks_scan_mm": {"nipple_L": [8.5, 120.0, -5.0]}}))
        self.refused(2, *words, "--landmarks", marks, says=["nipple_L", "off the scanned skin"])
        plan.write_text(json.dumps({**PLAN, "quadrant": "upper inner"}))  # left, half past one: outer
        self.refused(2, *words, "--plan", plan, says=["1:30", "upper inner", "left breast"])
        # As drawn the photograph's left is her right: only a mirror does that.
        (self.folder / "torso.mtl").write_text("newmtl skin\nmap_Kd skin.png\n")
        (self.folder / "skin.png").write_bytes(PIXEL)
        text = "mtllib torso.mtl\nusemtl skin\n" + scan.read_text()
        points = [line.split() for line in text.splitlines() if line.startswith("v ")]
        for flip, refused in [(-1, True), (1, False)]:
            placed = "".join(f"vt {0.5 + flip * float(p[1]) / 400} {(float(p[2]) - 1000) / 400}\n"
                             for p in points)
            faces = "".join("f " + " ".join(f"{v}/{v}" for v in line.split()[1:]) + "\n"
                            if line.startswith("f ") else line + "\n" for line in text.splitlines())
            scan.write_text(placed + faces)
            if refused:
                self.refused(2, *words, says=["mirror", "photograph"])
            else:
                self.run_ok(*words)


if __name__ == "__main__":
    main()
