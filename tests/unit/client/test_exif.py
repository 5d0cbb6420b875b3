"""EXIF data of photographs: camera, size, focal lengths."""

import struct
from pathlib import Path

import pytest

from calibdb_client import UsageError, exif

IMG_SIZE = (4032, 3024)


def block(order: str = "<", make: str = "Apple", model: str = "iPhone 13", focal_35mm: int = 26) -> bytes:
    """TIFF structure with the tags that cameras write."""
    texts = [make.encode() + b"\0", model.encode() + b"\0"]
    first_entries, second_entries = 3, 2
    after_first = 8 + 2 + 12 * first_entries + 4
    after_second = after_first + 2 + 12 * second_entries + 4
    at = [after_second, after_second + len(texts[0])]
    rational_at = at[1] + len(texts[1])
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(f"{order}L", 8)
    first = struct.pack(f"{order}H", first_entries)
    for tag, text, place in ((0x010F, texts[0], at[0]), (0x0110, texts[1], at[1])):
        inline = text.ljust(4, b"\0") if len(text) <= 4 else struct.pack(f"{order}L", place)
        first += struct.pack(f"{order}HHL", tag, 2, len(text)) + inline
    first += struct.pack(f"{order}HHLL", 0x8769, 4, 1, after_first) + b"\0" * 4
    second = struct.pack(f"{order}H", second_entries)
    second += struct.pack(f"{order}HHLL", 0x920A, 5, 1, rational_at)
    second += struct.pack(f"{order}HHLHH", 0xA405, 3, 1, focal_35mm, 0) + b"\0" * 4
    return head + first + second + b"".join(texts) + struct.pack(f"{order}LL", 51, 10)


def jpeg(content: bytes) -> bytes:
    """JPEG headers with an EXIF block and a size, without a picture."""
    segment = b"Exif\0\0" + content
    frame = struct.pack(">BHHB", 8, IMG_SIZE[1], IMG_SIZE[0], 3)
    return (
        b"\xff\xd8\xff\xe1"
        + struct.pack(">H", len(segment) + 2)
        + segment
        + b"\xff\xc0"
        + struct.pack(">H", len(frame) + 2)
        + frame
        + b"\xff\xda"
        + b"\0" * 12
    )


@pytest.mark.parametrize("order", ["<", ">"])
def test_photograph_names_its_camera(tmp_path: Path, order: str) -> None:
    path = tmp_path / "IMG_1.jpg"
    path.write_bytes(jpeg(block(order)))
    found = exif.read(path)
    assert found == exif.Photograph("Apple", "iPhone 13", "", IMG_SIZE, 5.1, 26.0)
    assert found.label == "Apple iPhone 13"
    assert found.reported == {"focal_35mm": 26.0}


def test_makers_name_is_written_once(tmp_path: Path) -> None:
    path = tmp_path / "IMG_2.jpg"
    path.write_bytes(jpeg(block(make="Canon", model="Canon EOS R6")))
    assert exif.read(path).label == "Canon EOS R6"


@pytest.mark.parametrize("length", [0, 4, 60, 100])
def test_damaged_and_foreign_files_are_refused(tmp_path: Path, length: int) -> None:
    path = tmp_path / "IMG_3.jpg"
    path.write_bytes(jpeg(block())[:length])
    with pytest.raises(UsageError, match="EXIF"):
        exif.read(path)
    path.write_bytes(b"\x89PNG" + bytes(length))
    with pytest.raises(UsageError, match="EXIF"):
        exif.read(path)


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        exif.read(tmp_path / "none.jpg")
