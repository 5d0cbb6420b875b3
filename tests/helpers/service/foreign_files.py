"""Requests to convert small files at random: damaged real ones, and structures of hostile values."""

import base64
import json
import re
from pathlib import Path

from hypothesis import strategies as st

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
MATRIX = [[900.0, 0.0, 640.0], [0.0, 900.0, 360.0], [0.0, 0.0, 1.0]]
CAMERA = {"camera_matrix": MATRIX, "dist_coeffs": [0.1] * 5, "img_size": [1280, 720]}
SPLICES = (
    *(b"", b"\0", b"\xff\xfe", b"\xed\xa0\x80", b"\x1b", b"!!python/tuple ", b"!!opencv-matrix", b"\\ud800"),
    *(b"null", b"NaN", b"1e999", b"9" * 400, b"%YAML:1.0\n---\n", b"---\n", b"<?xml?>", b"{'lensmodel': "),
    *(b"[image]\n", b"[a]\na=1\n[a]\n", *(bytes([c]) for c in b"()[]{}<>&*-.,:=%'\"\n\t")),
)


def _damaged(file: bytes, splices: list[tuple[int, int, bytes]]) -> bytes:
    for place, length, splice in splices:
        at = place % (len(file) + 1)
        file = file[:at] + splice + file[at + length :]
    return file


def _written(value: dict[str, object], form: str) -> bytes:
    lines = "\n".join(f"{key}{form}{inner}" for key, inner in value.items())
    text = {
        "json": json.dumps(value),
        "repr": repr(value),
        "xml": f"<opencv_storage>{_elements(value)}</opencv_storage>",
    }
    return text.get(form, lines).encode("utf-8", "surrogatepass")


def _elements(value: object) -> str:
    if isinstance(value, dict):
        return "".join(f"<{key}>{_elements(inner)}</{key}>" for key, inner in value.items())
    if isinstance(value, list):
        return " ".join(map(str, value))
    return str(value)


_PIECES = (
    st.sampled_from(SPLICES) | st.binary(max_size=20) | st.sampled_from(FILES).map(lambda file: file[:500])
)
_DAMAGES = st.tuples(st.integers(0, MAX_CHARACTERS), st.sampled_from((0, 0, 1, 3, 20, 200)), _PIECES)
_LEAVES = (
    *(st.sampled_from(TEXTS), st.none(), st.booleans(), st.floats(), st.integers(), st.just(MATRIX)),
    st.lists(st.floats() | st.integers(), max_size=14),
)
_NAMES = st.sampled_from(NAMES)
_VALUES = st.recursive(
    st.one_of(_LEAVES),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_NAMES, inner, max_size=6),
    max_leaves=12,
)
_MAPPINGS = st.dictionaries(_NAMES, _VALUES, max_size=6)
_FILES = st.one_of(
    st.builds(_damaged, st.sampled_from(FILES), st.lists(_DAMAGES, min_size=1, max_size=4)),
    st.builds(
        _written,
        _MAPPINGS | _MAPPINGS.map(lambda value: CAMERA | value),
        st.sampled_from(("json", "repr", "xml", " = ", ": ")),
    ),
)
#: bodies of conversions
REQUESTS = st.fixed_dictionaries(
    {
        "file": _FILES.map(lambda file: base64.b64encode(file[:MAX_CHARACTERS]).decode() or "AA=="),
        "encoding": st.just("base64"),
    },
    optional={
        "img_size": st.sampled_from(([1280, 720], [16, 16], [720, 1280])),
        "format": st.sampled_from(("ros", "lensfun", "photonvision", "gyroflow", "mrcal", "kalibr")),
        "distortion_model": st.sampled_from(("fisheye", "rectilinear", "rational", "omnidirectional")),
        "number": st.sampled_from((0, 0, 0, 1, 63)),
    },
)
