#!/usr/bin/env python3
"""Copies of the mean of real standing scans with smaller breasts, for docs/theory/scan-only.md.

    SANATRIX_SHARED=... /usr/bin/python3 bench/small_breasts.py OUT [SHARE_RIGHT SHARE_LEFT]

writes OUT.obj (mm, y up) and OUT.marks.json with the true nipples and sternal notch. A straight
chest is drawn between the skin below and above the breasts; what stands in front of it is scaled.
"""
import json
import os
import sys
from pathlib import Path

import numpy as np
from scipy import ndimage

SPACING_MM, LOW_MM, COUNT = 4.0, -260.0, 131
BELOW_MM, ABOVE_MM = -100.0, 120.0  # of the breasts
SCANNER_HEIGHT_MM = 1150.0


def read_obj(path):
    points, faces = [], []
    for line in open(path):
        words = line.split()
        if line.startswith("v "):
            points.append([float(w) for w in words[1:4]])
        elif line.startswith("f "):
            faces.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(points), np.array(faces)


def front_of(points):
    """y of the foremost skin per column, LPS; columns without skin take the nearest one's."""
    columns = np.round((points[:, [0, 2]] - LOW_MM) / SPACING_MM).astype(int).clip(0, COUNT - 1)
    front = np.full((COUNT, COUNT), 1e9)
    np.minimum.at(front, (columns[:, 0], columns[:, 1]), points[:, 1])
    nearest = ndimage.distance_transform_edt(front > 1e8, return_distances=False,
                                             return_indices=True)
    return front[tuple(nearest)]


def chest_of(front):
    """A cubic in z per column of x, fading into the skin at the flanks."""
    x, z = np.meshgrid(*2 * [LOW_MM + SPACING_MM * np.arange(COUNT)], indexing="ij")
    smooth = ndimage.gaussian_filter(front, 2.0)
    low, high = (int((h - LOW_MM) / SPACING_MM) for h in (BELOW_MM, ABOVE_MM))
    run = 6
    y0, y1, s0, s1 = (ndimage.gaussian_filter1d(a, w)[:, None] for a, w in (
        (smooth[:, low], 3), (smooth[:, high], 3),
        (0.5 * (smooth[:, low] - smooth[:, low - run]) / (run * SPACING_MM), 4),
        (0.8 * (smooth[:, high + run] - smooth[:, high]) / (run * SPACING_MM), 4)))
    length = ABOVE_MM - BELOW_MM
    t = ((z - BELOW_MM) / length).clip(0, 1)
    chest = ((2 * t**3 - 3 * t**2 + 1) * y0 + (t**3 - 2 * t**2 + t) * length * s0
             + (3 * t**2 - 2 * t**3) * y1 + (t**3 - t**2) * length * s1)
    share = (np.where(z > 60, 172 - abs(x), 195 - abs(x)) / 25).clip(0, 1)
    share = ndimage.gaussian_filter(share, 2.0)
    share = share**2 * (3 - 2 * share)
    inside = (z > BELOW_MM) & (z < ABOVE_MM)
    chest = np.where(inside, share * chest + (1 - share) * front, front)
    return ndimage.gaussian_filter(np.maximum(chest, front), 1.0)


def main():
    out = sys.argv[1]
    shares = [float(s) for s in sys.argv[2:4]] or [0.35, 0.35]
    folder = Path(os.environ.get("SANATRIX_SHARED", "../shared")) / "data/scan_lirbsm_mean"
    scan, faces = read_obj(folder / "lirbsm_mean_upright.obj")
    about = json.load(open(folder / "lirbsm_mean_upright.json"))
    to_scan = np.array(about["true_source_to_scan_4x4"])
    points = (scan - to_scan[:3, 3]) @ to_scan[:3, :3]  # LPS
    chest = chest_of(front_of(points))
    at = ndimage.map_coordinates(chest, (points[:, [0, 2]].T - LOW_MM) / SPACING_MM, order=1,
                                 mode="nearest")
    inside = (abs(points[:, 0]) < 195) & (points[:, 2] > BELOW_MM) & (points[:, 2] < ABOVE_MM)
    rise = np.where(inside, at - points[:, 1], 0).clip(0)
    true = [np.argmin(((points - np.array(p)) ** 2).sum(1)) for p in (
        about["landmarks_source_mm"]["nipple_R"], about["landmarks_source_mm"]["nipple_L"],
        about["landmarks_source_mm"]["sternal_notch"])]
    points[:, 1] += (1 - np.where(points[:, 0] < 0, *shares)) * rise
    upright = np.stack([points[:, 0], points[:, 2] + SCANNER_HEIGHT_MM, -points[:, 1]], 1)
    with open(out + ".obj", "w") as file:
        file.writelines("v %.3f %.3f %.3f\n" % tuple(p) for p in upright)
        file.writelines("f %d %d %d\n" % tuple(f) for f in faces + 1)
    names = ("nipple_R", "nipple_L", "sternal_notch")
    marks = {name: list(upright[i]) for name, i in zip(names, true)}
    json.dump({"landmarks_scan_mm": marks}, open(out + ".marks.json", "w"))


if __name__ == "__main__":
    main()
