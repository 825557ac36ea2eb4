"""The development patients' own DICOM, made worse file by file. Usage: patient_images_test.py PROGRAM"""
import json
import os
import pathlib
import random
import unittest

from sanatrix_cli import CliTest, main

DATA = pathlib.Path(os.environ.get(
    "SANATRIX_SHARED", pathlib.Path(__file__).parents[2] / ".." / "shared")) / "data"
SERIES = {"dev01": "series004_t1", "dev02": "series005_t2"}  # explicit and implicit VR


@unittest.skipUnless((DATA / "dev01/dicom").is_dir(), f"{DATA}/dev01/dicom is absent")
class PatientImages(CliTest):
    def copy(self, patient, name, keep=lambda k: True, change=lambda data: data):
        """The patient's slices under names that say nothing, in no order."""
        folder = self.folder / name
        folder.mkdir()
        files = sorted((DATA / patient / "dicom" / SERIES[patient]).iterdir())
        random.Random(4).shuffle(files)
        for file in files:
            number = int(file.stem[2:])
            if keep(number):
                (folder / f"{random.Random(number).random():.15f}").write_bytes(
                    change(file.read_bytes()))
        return folder

    def imported(self, path):
        case = self.folder / f"case {len(list(self.folder.iterdir()))}"
        self.run_ok("new", case, "--image", path)
        return (case / "inputs/image.nrrd").read_bytes()

    def position(self, patient, value):
        def change(data):
            self.assertEqual(data.count(b"HFP "), 1)
            return data.replace(b"HFP ", value)
        return self.copy(patient, f"{patient} {value.decode()}", change=change)

    def test_the_order_and_names_of_the_files_do_not_matter(self):
        for patient in SERIES:
            self.assertEqual(self.imported(DATA / patient / "dicom"),
                             self.imported(self.copy(patient, f"{patient} shuffled")))

    def test_missing_slices_are_an_error_and_thin_stacks_warn(self):
        for patient in SERIES:
            folder = self.copy(patient, f"{patient} gap", keep=lambda k: k not in (20, 21))
            self.refused(2, "new", self.folder / "case", "--image", folder,
                         says=["2 slice(s) are missing"])
            folder = self.copy(patient, f"{patient} third", keep=lambda k: k % 3 == 0)
            series = json.loads(self.run_ok("inspect", folder, "--json").stdout)["series"]
            self.assertTrue(series[0]["chosen"])
            self.assertIn("9.0 mm apart but only 3.0 mm thick", " ".join(series[0]["warnings"]))

    # Slices carry their own place and directions: feet first changes nothing, lying on the back does.
    def test_a_flipped_patient_position_is_right_or_refused(self):
        self.assertEqual(self.imported(DATA / "dev02/dicom"),
                         self.imported(self.position("dev02", b"FFP ")))
        for patient in SERIES:
            self.refused(2, "new", self.folder / "case", "--image",
                         self.position(patient, b"HFS "), says=["supine"])


if __name__ == "__main__":
    main()
