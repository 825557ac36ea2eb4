"""Images in: DICOM series are chosen, checked and made anonymous. Usage: image_test.py PROGRAM"""
import gzip
import json
import math
import random
import re
import struct

from dicom_files import Series, dicom_file, element
from sanatrix_cli import CliTest, _label, main, sanatrix, write_nifti, write_patient


def torso():
    return Series(_label)


def voxels(case):
    """Header text without comments, and the values, of the image that a case holds."""
    data = (case / "inputs/image.nrrd").read_bytes()
    head, body = data.split(b"\n\n", 1)
    kind = re.search(rb"type: (.*)", head).group(1).decode()
    raw = gzip.decompress(body)
    code = {"float": "f", "short": "h", "unsigned short": "H", "int16": "h", "uint16": "H"}[kind]
    return head, struct.unpack(f"<{len(raw) // struct.calcsize(code)}{code}", raw)


# Places where patients' and physicians' names hide: keys of PS3.15 Table E.1-1.
IDENTIFYING = [
    (0x00080012, "DA"), (0x00080014, "UI"), (0x00080020, "DA"), (0x00080021, "DA"),
    (0x00080022, "DA"), (0x00080023, "DA"), (0x0008002A, "DT"), (0x00080030, "TM"),
    (0x00080050, "SH"), (0x00080080, "LO"), (0x00080081, "ST"), (0x00080090, "PN"),
    (0x00080092, "ST"), (0x00080094, "SH"), (0x00081010, "SH"), (0x00081030, "LO"),
    (0x0008103E, "LO"), (0x00081040, "LO"), (0x00081048, "PN"), (0x00081050, "PN"),
    (0x00081060, "PN"), (0x00081070, "PN"), (0x00081080, "LO"), (0x00081090, "LO"),
    (0x00082111, "ST"), (0x00100010, "PN"), (0x00100020, "LO"), (0x00100021, "LO"),
    (0x00100030, "DA"), (0x00100032, "TM"), (0x00101000, "LO"), (0x00101001, "PN"),
    (0x00101005, "PN"), (0x00101040, "LO"), (0x00101060, "PN"), (0x00101090, "LO"),
    (0x00102154, "SH"), (0x00102160, "SH"), (0x00102180, "SH"), (0x001021B0, "LT"),
    (0x00104000, "LT"), (0x00181000, "LO"), (0x00181030, "LO"), (0x00180010, "LO"),
    (0x00184000, "LT"), (0x00200010, "SH"), (0x00204000, "LT"), (0x00321032, "PN"),
    (0x00324000, "LT"), (0x00380010, "LO"), (0x00400006, "PN"), (0x00400254, "LO"),
    (0x00402016, "LO"), (0x4008010C, "PN"),
]


def planted():
    """60 identifiers in public, private and nested elements, and what to search for."""
    secrets, elements = [], {}

    def secret(vr):
        digits = f"{len(secrets):02}"
        text = {"DA": f"196107{digits}", "TM": f"0742{digits}", "DT": f"196108{digits}0742",
                "UI": f"1.2.840.777{digits}.55"}.get(vr, f"Qxzelda{digits}")
        secrets.append(text)
        return text

    for tag, vr in IDENTIFYING:
        elements[tag] = element(tag, vr, secret(vr))
    elements[0x00290010] = element(0x00290010, "LO", "SIEMENS " + secret("LO"))
    elements[0x00291010] = element(0x00291010, "UN", secret("LO").encode() + b"\0csa")
    elements[0x00131010] = element(0x00131010, "LO", secret("LO"))
    nested = [element(0x00080100, "SH", "C1"), element(0x00080104, "LO", secret("LO")),
              element(0x00401101, "SQ", [[element(0x00100010, "PN", secret("PN")),
                                          element(0x00291011, "LO", secret("LO"))]])]
    elements[0x00081110] = element(0x00081110, "SQ", [nested])
    return secrets, elements


class Images(CliTest):
    def test_the_right_series_is_chosen_among_others(self):
        folder = self.folder / "study"
        torso().write(folder / "a")
        scout = torso()
        scout.slices, scout.spacing, scout.number, scout.uid = 3, 40.0, 1, "1.2.3.100"
        scout.write(folder / "scout")
        suppressed = torso()
        suppressed.number, suppressed.uid = 2, "1.2.3.200"
        suppressed.extra[0x00180022] = element(0x00180022, "CS", "FS")
        suppressed.write(folder / "fs")
        (folder / "README.txt").write_text("not an image")
        found = json.loads(self.run_ok("inspect", folder, "--json").stdout)
        self.assertEqual([s["chosen"] for s in found["series"]], [False, False, True])
        self.assertIn("localizer", found["series"][0]["not_chosen_because"])
        self.assertIn("fat", found["series"][1]["not_chosen_because"])
        self.assertEqual(found["files_without_image"], 1)
        by_hand = json.loads(self.run_ok("inspect", folder, "--series", 2, "--json").stdout)
        self.assertEqual([s["chosen"] for s in by_hand["series"]], [False, True, False])
        self.refused(2, "new", self.folder / "case", "--image", folder / "fs", says=["fat"])
        self.refused(2, "new", self.folder / "case", "--image", folder, "--series", 9)

    def test_order_names_and_container_of_the_slices_do_not_matter(self):
        plain = torso().write(self.folder / "plain")
        names = [f"{random.Random(k).random():.12f}" for k in range(30)]
        shuffled = torso()
        shuffled.write(self.folder / "shuffled", names)
        for name, path in [("plain", plain), ("shuffled", self.folder / "shuffled")]:
            self.run_ok("new", self.folder / f"case-{name}", "--image", path)
        head, values = voxels(self.folder / "case-plain")
        self.assertEqual((head, values), voxels(self.folder / "case-shuffled"))
        self.assertEqual(values[:130], struct.unpack("<8580H", torso().pixels(0))[:130])
        self.assertIn(b"left-posterior-superior", head)
        self.assertIn(b"space origin: (-129,-60,-58)", head)
        self.assertIn(b"(0,0,4)", head)
        # One multi-frame file with frames out of order; its values are rescaled by 2 v - 100.
        one = torso().write_enhanced(self.folder / "enhanced.dcm")
        self.run_ok("new", self.folder / "case-enhanced", "--image", one)
        enhanced_head, enhanced = voxels(self.folder / "case-enhanced")
        self.assertEqual(list(enhanced), [2 * v - 100 for v in values])
        self.assertIn(b"space origin: (-129,-60,-58)", enhanced_head)

    def test_gaps_and_repeats_are_errors_and_thin_stacks_warn(self):
        folder = torso().write(self.folder / "gap")
        (folder / "IM0012.dcm").unlink()
        self.refused(2, "new", self.folder / "case", "--image", folder,
                     says=["1 slice", "missing"])
        folder = torso().write(self.folder / "twice")
        (folder / "copy.dcm").write_bytes((folder / "IM0012.dcm").read_bytes())
        self.refused(2, "new", self.folder / "case", "--image", folder, says=["same position"])
        folder = torso().write(self.folder / "mixed")
        tilted = torso()
        tilted.row, tilted.column = (0, 1, 0), (0, 0, -1)
        (folder / "IM0030.dcm").write_bytes(dicom_file(tilted.elements(29)))
        self.refused(2, "new", self.folder / "case", "--image", folder, says=["orientation"])
        self.assertFalse((self.folder / "case").exists())
        folder = torso().write(self.folder / "third")
        for k in range(30):
            if k % 3:
                (folder / f"IM{k + 1:04}.dcm").unlink()
        found = json.loads(self.run_ok("inspect", folder, "--json").stdout)["series"][0]
        self.assertIn("12.0 mm apart but only 4.0 mm thick", " ".join(found["warnings"]))

    def test_a_supine_patient_and_other_modalities_are_refused(self):
        for tag, value, word in [(0x00185100, "HFS", "supine"), (0x00185100, "HFDL", "HFDL"),
                                 (0x00080060, "CT", "not an MRI")]:
            other = torso()
            other.extra[tag] = element(tag, "CS", value)
            folder = other.write(self.folder / value)
            self.refused(2, "new", self.folder / "case", "--image", folder, says=[word])

    def test_two_patients_in_one_folder_are_an_error(self):
        folder = self.folder / "study"
        torso().write(folder / "a")
        other = torso()
        other.number, other.uid = 4, "1.2.3.400"
        other.extra[0x00100020] = element(0x00100020, "LO", "Q")
        other.write(folder / "b")
        said = self.refused(2, "new", self.folder / "case", "--image", folder,
                            says=["different patients", "--series"])
        self.assertNotIn("Q", said)
        self.run_ok("new", self.folder / "case", "--image", folder, "--series", 2)

    def test_what_was_assumed_is_a_warning(self):
        folder = self.folder / "study"
        for n, study in enumerate(["1.2.3", "1.2.4"]):
            series = torso()
            series.number, series.uid = n, f"1.2.3.{n}"
            series.extra[0x0020000D] = element(0x0020000D, "UI", study)
            series.extra[0x00185100] = element(0x00185100, "CS", "")
            series.write(folder / str(n))
        case = self.folder / "case"
        said = self.run_ok("new", case, "--image", folder).stderr
        self.assertIn("prone is assumed", said)
        self.assertIn("another examination", said)
        self.assertEqual(len(json.loads((case / "inputs/image.json").read_text())["warnings"]), 2)

    def test_values_are_what_the_header_says(self):
        plain = torso().write(self.folder / "plain")
        self.run_ok("new", self.folder / "case-plain", "--image", plain)
        _, values = voxels(self.folder / "case-plain")
        inverted = torso()
        inverted.extra[0x00280004] = element(0x00280004, "CS", "MONOCHROME1")
        self.run_ok("new", self.folder / "case-inverted", "--image",
                    inverted.write(self.folder / "inverted"))
        self.assertEqual([4095 - v for v in values],
                         list(voxels(self.folder / "case-inverted")[1]))
        for slope, word in [("0", "rescale slope 0"), ("1e300", "rescale slope 1e+300")]:
            scaled = torso()
            scaled.extra[0x00281053] = element(0x00281053, "DS", slope)
            self.refused(2, "new", self.folder / "case", "--image",
                         scaled.write(self.folder / slope), says=[word])
        bare = self.folder / "bare"  # data sets without preamble and meta header, as old archives have
        bare.mkdir()
        for file in plain.iterdir():
            data = file.read_bytes()
            (bare / file.name).write_bytes(data[data.index(b"\x08\x00\x05\x00CS"):])
        self.run_ok("new", self.folder / "case-bare", "--image", bare)
        self.assertEqual(values, voxels(self.folder / "case-bare")[1])
        flat = self.folder / "flat.nii.gz"
        write_nifti(flat, (30, 30, 30), 2.0, (0, 0, 0), bytes(27000))
        self.refused(2, "new", self.folder / "case", "--image", flat, says=["all voxels"])

    def test_no_identifier_survives(self):
        secrets, elements = planted()
        self.assertEqual(len(secrets), 60)
        series = torso()
        series.extra = elements
        folder = series.write(self.folder / "Qxzelda99 study")
        for file in folder.iterdir():  # they are there
            data = file.read_bytes()
            self.assertTrue(all(s.encode() in data for s in secrets))
        plan = self.folder / "plan.json"
        plan.write_text(json.dumps({
            "patient": "Qxzelda98", "operated_side": "L", "quadrant": "upper outer Qxzelda97",
            "comment": "Qxzelda96", "planned_margin_mm": 8.0,
            "tumour": {"centre_lps_mm": [70, -8, 8], "equivalent_radius_mm": 7,
                       "seen_by": "Qxzelda95"}}))
        case = self.folder / "case"
        said = self.run_ok("new", case, "--image", folder, "--plan", plan)
        self.run_ok("run", case, "--to", "image")
        inspected = self.run_ok("inspect", folder)
        texts = {"stdout": said.stdout + said.stderr + inspected.stdout + inspected.stderr}
        for file in case.rglob("*"):
            if file.is_file():
                data = file.read_bytes()
                if file.name.endswith(".nrrd"):
                    head, body = data.split(b"\n\n", 1)
                    data = head + gzip.decompress(body)
                texts[file.name] = data.decode("latin-1")
        for name, text in texts.items():
            text = text.replace(str(folder), "").replace(str(self.folder), "")
            for secret in secrets + ["Qxzelda", "1961", self.folder.name]:
                self.assertNotIn(secret, text, name)
        facts = json.loads((case / "inputs/image.json").read_text())
        self.assertEqual(facts["deidentification"]["method_codes"], ["113100"])
        self.assertGreaterEqual(facts["deidentification"]["elements_left_behind"], 60)

    def tumour_mask(self, name, centre):
        """A ball of 7 mm as a mask of 2 mm voxels."""
        spacing, origin, size = 2.0, (-100.0, -50.0, -40.0), (101, 60, 41)
        voxels = bytes(math.dist([o + spacing * n for o, n in zip(origin, (i, j, k))], centre) < 7.0
                       for k in range(size[2]) for j in range(size[1]) for i in range(size[0]))
        write_nifti(self.folder / name, size, spacing, origin, voxels)
        return self.folder / name

    def test_a_mask_says_where_the_tumour_is(self):
        folder = torso().write(self.folder / "study")
        _, plan = write_patient(self.folder / "patient")
        case = self.folder / "case"
        self.run_ok("new", case, "--image", folder, "--plan", plan,
                    "--tumour", self.tumour_mask("there.nii.gz", (72, -8, 8)))
        kept = json.loads((case / "inputs/tumour.json").read_text())
        self.assertLess(math.dist(kept["centre_lps_mm"], (72, -8, 8)), 0.2)
        self.assertAlmostEqual(kept["radius_mm"], 7.0, delta=0.3)
        self.refused(2, "new", self.folder / "other", "--image", folder, "--plan", plan,
                     "--tumour", self.tumour_mask("other.nii.gz", (-72, -8, 8)), says=["tumour"])
        self.refused(2, "new", self.folder / "none", "--image", folder, "--plan", plan,
                     "--tumour", self.tumour_mask("none.nii.gz", (0, 900, 0)), says=["empty"])

    def test_landmarks_are_where_the_skin_says(self):
        labels, plan = write_patient(self.folder / "patient")
        case = self.folder / "case"
        self.run_ok("new", case, "--labels", labels, "--plan", plan)
        self.run_ok("run", case, "--to", "segment", "--set", "segment.spacing_mm=2")
        marks = json.loads(next(case.glob("stages/*/landmarks.json")).read_text())
        # The breasts are ellipsoids about (+-62, 17, 0) with half axes of 46, 62 and 50 mm.
        for side, x in [("right", -62), ("left", 62)]:
            mark = marks[f"nipple_{side}"]
            self.assertLess(math.dist(mark["lps_mm"], (x, -45, 0)), 4.0)
            self.assertGreater(mark["confidence"], 0.5)
        self.assertLess(abs(marks["midline"]["lps_mm"][0]), 2.0)

    def test_damaged_files_never_crash_the_program(self):
        whole = torso().write(self.folder / "whole")
        source = (whole / "IM0001.dcm").read_bytes()
        codes = {}
        for seed in range(30):
            rng = random.Random(seed)
            data = bytearray(source)
            for _ in range(rng.choice([1, 4, 16])):
                at = rng.randrange(128, len(data) if seed % 3 else 900)
                kind = rng.randrange(4)
                if kind == 0:
                    data[at] = rng.randrange(256)
                elif kind == 1:
                    data[at:at + 4] = struct.pack("<I", rng.choice([0, 0xFFFFFFFF, 0x7FFFFFFF]))
                elif kind == 2:
                    del data[at:at + rng.randrange(1, 40)]
                else:
                    data[at:at] = data[at:at + rng.randrange(1, 400)]
            if seed % 10 == 0:
                del data[rng.randrange(140, len(data)):]
            (whole / "IM0001.dcm").write_bytes(bytes(data))
            result = sanatrix("inspect", whole)
            codes[result.returncode] = codes.get(result.returncode, 0) + 1
            self.assertIn(result.returncode, (0, 2, 4), f"seed {seed}: {result.stderr}")
            self.assertLessEqual(len(result.stderr.strip().splitlines()), 1)
        self.assertGreater(codes.get(2, 0), 0)


if __name__ == "__main__":
    main()
