"""Writes small DICOM series (explicit VR little endian, python's standard library only)."""
import random
import struct

IMPLICIT, EXPLICIT = "1.2.840.10008.1.2", "1.2.840.10008.1.2.1"
MR, ENHANCED_MR = "1.2.840.10008.5.1.4.1.1.4", "1.2.840.10008.5.1.4.1.1.4.1"
LONG_VR = {"OB", "OW", "SQ", "UN", "UT"}


def element(tag, vr, value):
    """One data element; value: text, numbers, bytes, or a list of items (lists of elements)."""
    group, number = tag >> 16, tag & 0xFFFF
    if vr == "SQ":
        data = b"".join(struct.pack("<HHI", 0xFFFE, 0xE000, len(item)) + item
                        for item in (b"".join(elements) for elements in value))
    elif vr == "US":
        values = value if isinstance(value, (list, tuple)) else [value]
        data = struct.pack(f"<{len(values)}H", *values)
    elif vr == "FD":
        values = value if isinstance(value, (list, tuple)) else [value]
        data = struct.pack(f"<{len(values)}d", *values)
    elif isinstance(value, bytes):
        data = value
    else:
        text = "\\".join(str(v) for v in value) if isinstance(value, (list, tuple)) else str(value)
        data = text.encode("latin-1")
    if len(data) % 2:
        data += b"\0" if vr in ("UI", "OB", "UN") else b" "
    if vr in LONG_VR:
        return struct.pack("<HH2sHI", group, number, vr.encode(), 0, len(data)) + data
    return struct.pack("<HH2sH", group, number, vr.encode(), len(data)) + data


def dicom_file(elements, sop_class=MR, sop_uid="1.2.3.4"):
    """elements: {tag: encoded element}."""
    meta = (element(0x00020002, "UI", sop_class) + element(0x00020003, "UI", sop_uid)
            + element(0x00020010, "UI", EXPLICIT))
    meta = struct.pack("<HH2sHI", 2, 0, b"UL", 4, len(meta)) + meta
    return b"\0" * 128 + b"DICM" + meta + b"".join(elements[tag] for tag in sorted(elements))


_DRAWN = {}  # pixels by place: drawing takes most of the time


class Series:
    """A stack of axial slices of a torso of simple shapes, 2 mm in plane."""

    def __init__(self, label_at, slices=30, spacing=4.0, columns=130, rows=66):
        self.label_at, self.slices, self.spacing = label_at, slices, spacing
        self.columns, self.rows, self.pixel = columns, rows, 2.0
        self.origin = (-129.0, -60.0, -0.5 * (slices - 1) * spacing)
        self.row, self.column = (1, 0, 0), (0, 1, 0)
        self.number, self.uid = 3, "1.2.3.300"
        self.extra = {}  # elements that every file gets besides

    # Relative signals of the labels in T1 without fat suppression; air is noise.
    SIGNAL = {0: 0, 1: 1000, 2: 330, 3: 380, 4: 230, 6: 35, 8: 260}

    def pixels(self, k):
        z = self.origin[2] + k * self.spacing
        if (k, z) not in _DRAWN:
            _DRAWN[k, z] = self._draw(k, z)
        return _DRAWN[k, z]

    def _draw(self, k, z):
        noise = random.Random(k)
        values = [max(0, int(self.SIGNAL[self.label_at(self.origin[0] + self.pixel * i,
                                                       self.origin[1] + self.pixel * j, z)]
                             + noise.gauss(0, 12)))
                  for j in range(self.rows) for i in range(self.columns)]
        return struct.pack(f"<{len(values)}H", *values)

    def elements(self, k):
        x, y, _ = self.origin
        z = self.origin[2] + k * self.spacing
        e = {tag: element(tag, vr, value) for tag, vr, value in [
            (0x00080005, "CS", "ISO_IR 100"), (0x00080008, "CS", ["ORIGINAL", "PRIMARY", "M"]),
            (0x00080016, "UI", MR), (0x00080018, "UI", f"{self.uid}.{k + 1}"),
            (0x00080060, "CS", "MR"), (0x00180050, "DS", self.spacing),
            (0x00180080, "DS", 600), (0x00180081, "DS", 12), (0x00180087, "DS", 1.5),
            (0x00185100, "CS", "HFP"), (0x0020000D, "UI", "1.2.3"), (0x0020000E, "UI", self.uid),
            (0x00200011, "IS", self.number), (0x00200013, "IS", k + 1),
            (0x00200032, "DS", (x, y, z)), (0x00200037, "DS", (*self.row, *self.column)),
            (0x00200052, "UI", "1.2.3.9"), (0x00280002, "US", 1),
            (0x00280004, "CS", "MONOCHROME2"), (0x00280010, "US", self.rows),
            (0x00280011, "US", self.columns), (0x00280030, "DS", (self.pixel, self.pixel)),
            (0x00280100, "US", 16), (0x00280101, "US", 12), (0x00280102, "US", 11),
            (0x00280103, "US", 0), (0x7FE00010, "OW", self.pixels(k))]}
        e.update(self.extra)
        return e

    def write(self, folder, names=None):
        folder.mkdir(parents=True, exist_ok=True)
        for k in range(self.slices):
            name = names[k] if names else f"IM{k + 1:04}.dcm"
            (folder / name).write_bytes(dicom_file(self.elements(k), MR, f"{self.uid}.{k + 1}"))
        return folder

    def write_enhanced(self, file):
        """The same stack as one enhanced multi-frame file, frames in a shuffled order."""
        order = list(range(self.slices))
        random.Random(5).shuffle(order)
        e = self.elements(0)
        for tag in (0x00200032, 0x00200037, 0x00280030, 0x00180050, 0x00180080, 0x00180081):
            del e[tag]
        x, y, z = self.origin
        shared = [element(0x00209116, "SQ", [[element(0x00200037, "DS",
                                                      (*self.row, *self.column))]]),
                  element(0x00289110, "SQ", [[element(0x00180050, "DS", self.spacing),
                                              element(0x00280030, "DS",
                                                      (self.pixel, self.pixel))]]),
                  element(0x00289145, "SQ", [[element(0x00281052, "DS", -100),
                                              element(0x00281053, "DS", 2)]])]
        frames = [[element(0x00209113, "SQ",
                           [[element(0x00200032, "DS", (x, y, z + k * self.spacing))]])]
                  for k in order]
        e[0x00080016] = element(0x00080016, "UI", ENHANCED_MR)
        e[0x00280008] = element(0x00280008, "IS", self.slices)
        e[0x52009229] = element(0x52009229, "SQ", [shared])
        e[0x52009230] = element(0x52009230, "SQ", frames)
        e[0x7FE00010] = element(0x7FE00010, "OW", b"".join(self.pixels(k) for k in order))
        file.write_bytes(dicom_file(e, ENHANCED_MR))
        return file
