#!/usr/bin/env python3
"""Copies of the mean of real standing scans that show the same woman, for docs/theory/scan-only.md.

    SANATRIX_SHARED=... /usr/bin/python3 bench/scan_copies.py FOLDER

writes plain, turned12, merged6, merged18, noise05, noise1, noise2 and fine2M as OBJ (mm, y up).
"""
import json
import os
import sys
from pathlib import Path

import numpy as np

from small_breasts import SCANNER_HEIGHT_MM, read_obj


def write(path, points, faces):
    with open(path, "w") as file:
        file.writelines("v %.4f %.4f %.4f\n" % tuple(p) for p in points)
        file.writelines("f %d %d %d\n" % tuple(f) for f in faces + 1)


def merged(points, faces, cube_mm):
    """One point per cube."""
    _, cube = np.unique(np.floor(points / cube_mm), axis=0, return_inverse=True)
    means = np.stack([np.bincount(cube, points[:, a]) / np.bincount(cube) for a in range(3)], 1)
    faces = cube[faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (a != c)]
    return means, faces[np.unique(np.sort(faces, 1), axis=0, return_index=True)[1]]


def quartered(points, faces):
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1)
    edges, number = np.unique(edges, axis=0, return_inverse=True)
    ab, bc, ca = (len(points) + number.reshape(3, -1))
    a, b, c = faces.T
    return (np.concatenate([points, points[edges].mean(1)]),
            np.concatenate([np.stack(t, 1) for t in
                            ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]))


def main():
    out = Path(sys.argv[1])
    out.mkdir(exist_ok=True)
    folder = Path(os.environ.get("SANATRIX_SHARED", "../shared")) / "data/scan_lirbsm_mean"
    scan, faces = read_obj(folder / "lirbsm_mean_upright.obj")
    to_scan = np.array(json.load(open(folder / "lirbsm_mean_upright.json"))
                       ["true_source_to_scan_4x4"])
    lps = (scan - to_scan[:3, 3]) @ to_scan[:3, :3]
    upright = np.stack([lps[:, 0], lps[:, 2] + SCANNER_HEIGHT_MM, -lps[:, 1]], 1)
    random = np.random.default_rng(7)
    write(out / "plain.obj", upright, faces)
    c, s = np.cos(np.radians(12)), np.sin(np.radians(12))
    write(out / "turned12.obj", upright @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), faces)
    for cube_mm in (6, 18):
        write(out / f"merged{cube_mm}.obj", *merged(upright, faces, cube_mm))
    for name, noise_mm in (("noise05", 0.5), ("noise1", 1.0), ("noise2", 2.0)):
        write(out / f"{name}.obj", upright + random.normal(0, noise_mm, upright.shape), faces)
    fine, fine_faces = quartered(*quartered(upright, faces))
    write(out / "fine2M.obj", fine + random.normal(0, 0.15, fine.shape), fine_faces)


if __name__ == "__main__":
    main()
