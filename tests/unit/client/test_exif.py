"""EXIF data of photographs: camera, size, focal lengths."""

import io
from pathlib import Path

import pytest
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

from calibdb_client import UsageError, exif

IMG_SIZE = (4032, 3024)


def jpeg(order: str = "<", make: str = "Apple", model: str = "iPhone 13", focal_35mm: int = 26) -> bytes:
    """Photograph with the tags that cameras write, in an order of bytes."""
    tags = Image.Exif()
    tags.endian = order
    tags[0x010F], tags[0x0110] = make, model
    tags.get_ifd(0x8769).update({0x920A: IFDRational(51, 10), 0xA405: focal_35mm})
    content = io.BytesIO()
    Image.new("L", IMG_SIZE).save(content, "JPEG", exif=tags)
    return content.getvalue()


@pytest.mark.parametrize("order", ["<", ">"])
def test_photograph_names_its_camera(tmp_path: Path, order: str) -> None:
    path = tmp_path / "IMG_1.jpg"
    path.write_bytes(jpeg(order))
    found = exif.read(path)
    assert found == exif.Photograph("Apple", "iPhone 13", "", IMG_SIZE, 5.1, 26.0)
    assert found.label == "Apple iPhone 13"
    assert found.reported == {"focal_35mm": 26.0}
    path.write_bytes(jpeg(order, "Canon", "Canon EOS R6"))
    assert exif.read(path).label == "Canon EOS R6", "the maker is written once"


@pytest.mark.parametrize("content", [jpeg()[:n] for n in (0, 4, 60, 100)] + [b"\x89PNG" + bytes(60)])
def test_damaged_and_foreign_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "IMG_3.jpg"
    path.write_bytes(content)
    with pytest.raises(UsageError, match="EXIF"):
        exif.read(path)
    with pytest.raises(UsageError, match="cannot be read"):
        exif.read(tmp_path / "none.jpg")
