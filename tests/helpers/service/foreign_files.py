"""Small files at random: damaged real ones, and structures of hostile values."""

from __future__ import annotations

import base64
import json
import random
from pathlib import Path

IMPORTS = Path(__file__).parents[2] / "data" / "imports"
MAX_CHARACTERS = 4000


def _words(*lines: str) -> list[str]:
    return " ".join(lines).split()


NAMES = (
    *_words(
        "camera camera_name camera_matrix cameraMatrix K M1 D1 intrinsics img_size image_size imageSize",
        "size resolution image_width image_height width height w h fx fy cx cy f focal c_x c_y xi k1 k2",
        "k3 k4 k5 k6 p1 p2 b2 dist_coeffs distortion_coefficients distortion D distortion_model",
        "camera_model model model_type name label cam0 cam1 camera_1 left right cameraIntrinsics",
        "distCoeffs data rows cols dt observations fisheye_params distortion_coeffs calib_dimension",
        "input_horizontal_stretch projection asymmetrical digital_lens projection_type focal_x",
        "colmap_model params lensmodel lens_model imagersize optimization_inputs icam_intrinsics",
        "calibrationObjectSize locationInImageSpace locationInObjectSpace radial_distortion",
        "RadialDistortion IntrinsicMatrix ImageSize tangential_distortion Camera.type",
        "projection_parameters mirror_parameters distortion_parameters Camera.fx Camera1.fx",
    ),
    *("\ud800", "\u202e", "\0", "cam" + "9" * 5000),
)
TEXTS = (
    *("\ud800", "\udfff\ud800", "\u202eevil\0<script>", "", " ", "\x85", "\u2028", "é", "²", "٣", "\\ud800"),
    *("9" * 5000, "[1, 2", "640, 480", "[640; 480]", "{[1]: 2}", "!!float x", "!!int ''", "!!bool x"),
    *("!!timestamp x", "!!binary é", "!!set {a}", "!!omap [1]", "!!pairs [[1]]", "!!python/tuple [1]"),
    *("!opencv-matrix [1]", "? [1]", "? {a: 1}", "<<: 1", "<<: [1]", "- ", ": ", "? "),
    *_words(
        "nan .inf -.inf 1e400 1e-400 0x1p3 1_000 1:30:00 2026-02-31 640x480 true null ~ calib.yaml fisheye",
        "equidistant plumb_bob radtan pinhole omni rational_polynomial frame brown LENSMODEL_OPENCV8 PINHOLE",
        "OPENCV opencv_fisheye !!float <a/> &amp; &#xD800; ' \" # %",
    ),
)
NUMBERS = (
    0,
    1,
    -1,
    0.5,
    640,
    480,
    900.0,
    1e12,
    -1e12,
    1e308,
    5e-324,
    2**63,
    10**30,
    65_536,
    65_537,
    1e-9,
    -0.0,
)
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
        self._files = sorted(
            path.read_bytes()[:MAX_CHARACTERS] for path in IMPORTS.rglob("*") if path.is_file()
        )

    def request(self) -> dict[str, object]:
        """Return the body of one conversion."""
        choice = self._random.choice
        raw = choice((self._damaged, self._structure))()[:MAX_CHARACTERS]
        body: dict[str, object] = {"file": base64.b64encode(raw).decode() or "AA==", "encoding": "base64"}
        if self._random.random() < 0.5:
            body["img_size"] = choice(([1280, 720], [16, 16], [720, 1280]))
        if self._random.random() < 0.2:
            body["format"] = choice(
                ("ros", "lensfun", "photonvision", "gyroflow", "opencv-yaml", "mrcal", "kalibr")
            )
        if self._random.random() < 0.2:
            body["distortion_model"] = choice(("fisheye", "rectilinear", "rational", "omnidirectional"))
        if self._random.random() < 0.1:
            body["number"] = choice((0, 1, 63))
        return body

    def _damaged(self) -> bytes:
        rng = self._random
        raw = bytearray(rng.choice(self._files))
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
                other = rng.choice(self._files)
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
            return rng.choice(
                (
                    MATRIX,
                    [900, 0, 640, 0, 900, 360, 0, 0, 1],
                    [0.1, -0.2, 0, 0, 0.1],
                    [1280, 720],
                    [900, 900, 640, 360],
                )
            )
        if kind == 5:
            return [rng.choice(NUMBERS) for _ in range(rng.choice((0, 1, 2, 3, 4, 5, 8, 9, 12, 14)))]
        if kind < 8:
            return [self._value(depth + 1) for _ in range(rng.randrange(4))]
        return self._mapping(depth + 1)

    def _mapping(self, depth: int) -> dict[str, object]:
        return {self._random.choice(NAMES): self._value(depth) for _ in range(self._random.randrange(7))}

    def _structure(self) -> bytes:
        rng = self._random
        value: object = self._mapping(0)
        if rng.random() < 0.5:
            value = {
                "camera_matrix": MATRIX,
                "dist_coeffs": [0.1, 0, 0, 0, 0],
                "img_size": [1280, 720],
                **self._mapping(0),
            }
        kind = rng.randrange(5)
        if kind < 2:
            text = json.dumps(value)
        elif kind == 2:
            text = repr(value)
        elif kind == 3:
            text = "\n".join(
                f"{key}{rng.choice((' = ', ': ', '='))}{inner}" for key, inner in dict(value).items()
            )  # type: ignore[call-overload]
        else:
            text = f"<opencv_storage>{self._elements(value)}</opencv_storage>"
        return text.encode("utf-8", rng.choice(("replace", "surrogatepass")))

    def _elements(self, value: object) -> str:
        if isinstance(value, dict):
            return "".join(f"<{key}>{self._elements(inner)}</{key}>" for key, inner in value.items())
        if isinstance(value, list):
            return " ".join(map(str, value))
        return str(value)
