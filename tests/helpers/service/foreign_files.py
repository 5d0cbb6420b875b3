"""Small files at random: damaged real ones, and structures of hostile values."""

from __future__ import annotations

import base64
import json
import random
import re
from pathlib import Path

IMPORTS = Path(__file__).parents[2] / "data" / "imports"
MAX_CHARACTERS = 4000


FILES = sorted(path.read_bytes()[:MAX_CHARACTERS] for path in IMPORTS.rglob("*") if path.is_file())
#: names and words of real files, and hostile ones
NAMES = (
    *sorted({word.decode() for file in FILES for word in re.findall(rb"\b[A-Za-z][\w.]{0,30}\b", file)}),
    *("\ud800", "\u202e", "\0", "cam" + "9" * 5000),
)
TEXTS = (
    *("\ud800", "\udfff\ud800", "\u202eevil\0<script>", "", " ", "\x85", "\u2028", "é", "²", "٣", "\\ud800"),
    *("9" * 5000, "[1, 2", "640, 480", "[640; 480]", "{[1]: 2}", "!!float x", "!!int ''", "!!bool x"),
    *("!!timestamp x", "!!binary é", "!!set {a}", "!!omap [1]", "!!pairs [[1]]", "!!python/tuple [1]"),
    *("!opencv-matrix [1]", "? [1]", "? {a: 1}", "<<: 1", "<<: [1]", "- ", ": ", "? ", "nan", "-.inf"),
    *("1e400", "0x1p3", "1_000", "1:30:00", "2026-02-31", "640x480", "true", "~", "calib.yaml", "fisheye"),
    *("plumb_bob", "LENSMODEL_OPENCV8", "OPENCV", "<a/>", "&amp;", "&#xD800;", "'", '"', "#", "%"),
)
NUMBERS = (0, 1, -1, 0.5, 640, 900.0, 1e12, 1e308, 5e-324, 2**63, 10**30, 65_536, 1e-9, -0.0)
MATRIX = [[900.0, 0.0, 640.0], [0.0, 900.0, 360.0], [0.0, 0.0, 1.0]]
SPLICES = (
    *(b"\0", b"\xff\xfe", b"\xed\xa0\x80", b"\x1b", b"!!python/tuple ", b"!!opencv-matrix", b"\\ud800"),
    *(b"null", b"NaN", b"1e999", b"9" * 400, b"%YAML:1.0\n---\n", b"---\n", b"<?xml?>", b"{'lensmodel': "),
    *(b"[image]\n", b"[a]\na=1\n[a]\n", *(bytes([c]) for c in b"()[]{}<>&*-.,:=%'\"\n\t")),
)


class ForeignFiles:
    """Generator of files, the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)

    def request(self) -> dict[str, object]:
        choice = self._random.choice
        raw = choice((self._damaged, self._structure))()[:MAX_CHARACTERS]
        body: dict[str, object] = {"file": base64.b64encode(raw).decode() or "AA==", "encoding": "base64"}
        if self._random.random() < 0.5:
            body["img_size"] = choice(([1280, 720], [16, 16], [720, 1280]))
        if self._random.random() < 0.2:
            body["format"] = choice(("ros", "lensfun", "photonvision", "gyroflow", "mrcal", "kalibr"))
        if self._random.random() < 0.2:
            body["distortion_model"] = choice(("fisheye", "rectilinear", "rational", "omnidirectional"))
        if self._random.random() < 0.1:
            body["number"] = choice((0, 1, 63))
        return body

    def _damaged(self) -> bytes:
        rng = self._random
        raw = bytearray(rng.choice(FILES))
        for _ in range(rng.choice((1, 1, 2, 4, 12))):
            at = rng.randrange(len(raw) + 1)
            to = min(len(raw), at + rng.choice((0, 1, 1, 3, 20, 200)))
            kind = rng.randrange(5)
            if kind == 0:
                raw[at:to] = rng.choice(SPLICES)
            elif kind == 1:
                raw[at:to] = b""
            elif kind == 2:
                raw[at:to] = bytes(rng.randrange(256) for _ in range(to - at))
            elif kind == 3:
                other = rng.choice(FILES)
                begin = rng.randrange(len(other) + 1)
                raw[at:to] = other[begin : begin + rng.choice((5, 50, 500))]
            else:
                raw[at:at] = raw[at:to] * rng.choice((1, 2, 9))
        return bytes(raw)

    def _value(self, depth: int = 0) -> object:
        rng = self._random
        kind = rng.randrange(10 if depth < 4 else 6)
        if kind < 2:
            return rng.choice(NUMBERS)
        if kind == 2:
            return rng.choice(TEXTS)
        if kind == 3:
            return rng.choice((True, False, None, float("nan"), float("inf")))
        if kind == 4:
            return rng.choice((MATRIX, [0.1, -0.2, 0, 0, 0.1], [1280, 720], [900, 900, 640, 360]))
        if kind == 5:
            return [rng.choice(NUMBERS) for _ in range(rng.choice((0, 1, 2, 3, 4, 5, 8, 9, 12, 14)))]
        if kind < 8:
            return [self._value(depth + 1) for _ in range(rng.randrange(4))]
        return self._mapping(depth + 1)

    def _mapping(self, depth: int) -> dict[str, object]:
        return {self._random.choice(NAMES): self._value(depth) for _ in range(self._random.randrange(7))}

    def _structure(self) -> bytes:
        rng = self._random
        value = self._mapping(0)
        if rng.random() < 0.5:
            value = {"camera_matrix": MATRIX, "dist_coeffs": [0.1] * 5, "img_size": [1280, 720], **value}
        kind = rng.randrange(5)
        if kind < 2:
            text = json.dumps(value)
        elif kind == 2:
            text = repr(value)
        elif kind == 3:
            text = "\n".join(f"{key}{rng.choice((' = ', ': '))}{inner}" for key, inner in value.items())
        else:
            text = f"<opencv_storage>{self._elements(value)}</opencv_storage>"
        return text.encode("utf-8", rng.choice(("replace", "surrogatepass")))

    def _elements(self, value: object) -> str:
        if isinstance(value, dict):
            return "".join(f"<{key}>{self._elements(inner)}</{key}>" for key, inner in value.items())
        if isinstance(value, list):
            return " ".join(map(str, value))
        return str(value)
