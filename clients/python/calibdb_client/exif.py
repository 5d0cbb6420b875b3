"""EXIF data of a photograph: camera, lens, focal length. EXIF 2.32 (CIPA DC-008), in JPEG and TIFF files."""

import struct
from dataclasses import dataclass
from pathlib import Path

from .errors import UsageError

_MAKE, _MODEL, _WIDTH, _HEIGHT, _MORE = 0x010F, 0x0110, 0x0100, 0x0101, 0x8769
_FOCAL, _PIXEL_X, _PIXEL_Y, _FOCAL_35MM, _LENS = 0x920A, 0xA002, 0xA003, 0xA405, 0xA434
_SIZES = (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8)  # bytes of one value, by type
_ASCII, _SHORT, _LONG, _RATIONAL = 2, 3, 4, 5
_MAX_TEXT, _MAX_LABEL = 200, 128
_MIN_FOCAL_35MM = 3.0
_START_OF_FRAME = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
Entries = dict[int, tuple[int, int, int]]  # tag -> type, count, place of the value


@dataclass(frozen=True)
class Photograph:
    """Facts about a photograph, "" or 0 if missing.

    `size` is as the sensor wrote it, px; `focal_35mm` is the equivalent of `focal_mm` on 35 mm film.
    """

    make: str
    model: str
    lens: str
    size: tuple[int, int]
    focal_mm: float
    focal_35mm: float

    @property
    def label(self) -> str:
        """Camera and lens, as the pages write them: ``Canon EOS R6, RF24-70mm F2.8 L IS USM``."""
        brand = self.make.replace(",", " ").split(" ")[0]
        whole = self.model.lower().startswith(brand.lower())
        body = self.model if whole else " ".join(filter(None, (self.make, self.model)))
        return ", ".join(filter(None, (body, self.lens)))[:_MAX_LABEL]

    @property
    def reported(self) -> dict[str, float]:
        """Field of view that the file reports, as a lookup takes it."""
        return {"focal_35mm": self.focal_35mm} if self.focal_35mm > _MIN_FOCAL_35MM else {}


def read(path: Path) -> Photograph:
    """Read a photograph's EXIF data. Raises UsageError if the file has none that names a camera."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror}") from None
    try:
        photograph = _photograph(content)
    except (struct.error, IndexError, ZeroDivisionError):  # an offset that leads out of the file
        photograph = None
    if photograph is None or not photograph.label or min(photograph.size) < 1:
        raise UsageError(f"{path} does not name its camera: it has no EXIF data")
    return photograph


def _photograph(content: bytes) -> Photograph | None:
    frame = (0, 0)
    if content[:2] == b"\xff\xd8":
        start, frame = _in_jpeg(content)
        content = content[start:] if start else b""
    order = {b"II*\0": "<", b"MM\0*": ">"}.get(content[:4])
    if order is None:
        return None
    first = _directory(content, order, int(_number(content, order, _LONG, 4)))
    more = first.get(_MORE)
    second = _directory(content, order, int(_number(content, order, _LONG, more[2]))) if more else {}

    def number(entries: Entries, tag: int) -> float:
        return _number(content, order, entries[tag][0], entries[tag][2]) if tag in entries else 0.0

    width = frame[0] or number(second, _PIXEL_X) or number(first, _WIDTH)
    height = frame[1] or number(second, _PIXEL_Y) or number(first, _HEIGHT)
    make, model = (_text(content, first, tag) for tag in (_MAKE, _MODEL))
    size = (int(width), int(height))
    focal, focal_35mm = number(second, _FOCAL), number(second, _FOCAL_35MM)
    return Photograph(make, model, _text(content, second, _LENS), size, focal, focal_35mm)


def _in_jpeg(content: bytes) -> tuple[int, tuple[int, int]]:
    """Return the place of the EXIF block's TIFF header, 0 for none, and the size of the picture."""
    at, start, size = 2, 0, (0, 0)
    while at + 9 < len(content) and content[at] == 0xFF and content[at + 1] != 0xDA:
        marker, length = content[at + 1], struct.unpack_from(">H", content, at + 2)[0]
        if marker == 0xE1 and content[at + 4 : at + 10] == b"Exif\0\0":
            start = at + 10
        elif marker in _START_OF_FRAME:
            height, width = struct.unpack_from(">HH", content, at + 5)
            size = (width, height)
        at += 2 + length
    return start, size


def _directory(content: bytes, order: str, at: int) -> Entries:
    entries: Entries = {}
    (count,) = struct.unpack_from(f"{order}H", content, at)
    for index in range(count):
        place = at + 2 + 12 * index
        tag, kind, length = struct.unpack_from(f"{order}HHL", content, place)
        fits = kind < len(_SIZES) and _SIZES[kind] * length <= 4
        value = place + 8 if fits else struct.unpack_from(f"{order}L", content, place + 8)[0]
        entries[tag] = (kind, length, value)
    return entries


def _number(content: bytes, order: str, kind: int, at: int) -> float:
    if kind == _RATIONAL:
        above, below = struct.unpack_from(f"{order}LL", content, at)
        return float(round(above / below, 3))
    return float(struct.unpack_from(f"{order}{'H' if kind == _SHORT else 'L'}", content, at)[0])


def _text(content: bytes, entries: Entries, tag: int) -> str:
    kind, length, at = entries.get(tag, (0, 0, 0))
    if kind != _ASCII:
        return ""
    text = content[at : at + min(length, _MAX_TEXT)].split(b"\0")[0].decode("utf-8", "replace")
    return "".join(c if c.isprintable() else " " for c in text).strip()
