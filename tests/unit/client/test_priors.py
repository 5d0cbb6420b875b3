"""EXIF data of photographs, and priors by it for COLMAP, OpenSfM, openMVG and Meshroom."""

import io
import json
import shlex
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

from calibdb_client import Answer, Calibration, Estimate, UsageError, exif, priors
from calibdb_client.key import CameraKey

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


RECORD: dict[str, Any] = {
    "img_size": list(IMG_SIZE),
    "camera_matrix": [[3100.0, 0, 2015.5], [0, 3100.0, 1511.5], [0, 0, 1]],
    "distortion_model": "rectilinear",
    "distortion_coefficients": [0.1, -0.2, 0.001, 0.002, 0.0],
}
LIKELY = Estimate(
    {
        **RECORD,
        "distortion_coefficients": [0.0] * 5,
        "hfov_deg": 66.1,
        "interval_90": {"hfov_deg": [64.0, 68.2]},
        "basis": "published",
        "sources": [],
    }
)
asked: list[tuple[CameraKey, Mapping[str, float]]] = []


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three photographs of one phone, one of another, and files that say nothing."""
    photos = tmp_path / "photos"
    photos.mkdir()
    for name in ("a b.jpg", "b.JPG", "c.jpg"):
        (photos / name).write_bytes(jpeg())
    (photos / "d.jpg").write_bytes(jpeg(model="iPhone 14; rm -rf /\necho", focal_35mm=0))
    (photos / "screenshot.png").write_bytes(b"\x89PNG")
    (photos / "notes.txt").write_text("no picture")
    return photos


def groups(folder: Path, *, calibrated: bool) -> list[priors.PhotoGroup]:
    asked.clear()

    def lookup(key: CameraKey, reported: Mapping[str, float]) -> Answer:
        asked.append((key, reported))
        return Answer(Calibration(RECORD)) if calibrated else Answer(None, estimate=LIKELY)

    return priors.look_up(priors.photographs(folder), lookup)


def test_photographs_are_grouped_and_looked_up_by_their_camera(folder: Path) -> None:
    found = groups(folder, calibrated=False)
    names = [[path.name for path in group.paths] for group in found]
    assert names == [["a b.jpg", "b.JPG", "c.jpg"], ["d.jpg"]]
    key, reported = asked[0]
    assert key == CameraKey("Apple iPhone 13", "photographs", IMG_SIZE, 5.1)
    assert reported == {"focal_35mm": 26.0}
    assert asked[1][1] == {}
    assert "estimated (published), 90 %: 64.0 to 68.2 degrees" in found[0].title


def test_colmap_is_given_the_camera_at_its_pixel_centres(folder: Path) -> None:
    script = priors.colmap(groups(folder, calibrated=True))
    line = next(line for line in script.splitlines() if line.startswith("colmap feature_extractor"))
    words = shlex.split(line)
    assert words[words.index("--ImageReader.camera_model") + 1] == "OPENCV"
    assert words[words.index("--ImageReader.camera_params") + 1] == "3100,3100,2016,1512,0.1,-0.2,0.001,0.002"
    assert "--Mapper.ba_refine_focal_length 0" in script
    likely = priors.colmap(groups(folder, calibrated=False))
    assert "SIMPLE_RADIAL" in likely
    assert "ba_refine_focal_length" not in likely


def test_script_runs_and_a_cameras_name_runs_nothing(folder: Path, tmp_path: Path) -> None:
    work = tmp_path / "work"
    work.mkdir()
    (work / "colmap").write_text('#!/bin/sh\necho "$1" >> called\n')
    (work / "colmap").chmod(0o755)
    (work / "run.sh").write_text(priors.colmap(groups(folder, calibrated=False)))
    subprocess.run(
        ["/bin/sh", "run.sh", "db", "in", "out"], cwd=work, check=True, env={"PATH": f"{work}:/usr/bin:/bin"}
    )
    called = (work / "called").read_text().split()
    assert called == [*["feature_extractor"] * 2, "exhaustive_matcher", "mapper"]
    assert (work / "priors-1.txt").read_text().splitlines() == ["a b.jpg", "b.JPG", "c.jpg"]


def test_opensfm_finds_the_camera_under_its_own_name(folder: Path) -> None:
    cameras = json.loads(priors.opensfm(groups(folder, calibrated=True)))
    camera = cameras["v2 apple iphone 13 4032 3024 perspective 0.7222"]
    assert camera["focal_x"] == pytest.approx(3100 / 4032)


def test_sensor_widths_give_back_the_focal_length(folder: Path) -> None:
    name, width = priors.openmvg(groups(folder, calibrated=True)).splitlines()[0].split(";")
    assert name == "Apple iPhone 13"
    assert 5.1 * 4032 / float(width) == pytest.approx(3100, rel=1e-4)
    make, model, other, source = priors.meshroom(groups(folder, calibrated=True)).splitlines()[1].split(";")
    assert (make, model, source) == ("Apple", "iPhone 14  rm -rf / echo", "calibDB")
    assert float(other) == float(width)


def test_calibration_of_another_size_is_not_scaled(folder: Path) -> None:
    smaller = Answer(Calibration({**RECORD, "img_size": [2016, 1512]}))
    found = priors.look_up(priors.photographs(folder), lambda *_: smaller)
    with pytest.raises(UsageError, match="2016x1512"):
        priors.colmap(found)


def test_folders_without_cameras_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="EXIF"):
        priors.photographs(tmp_path)
    with pytest.raises(UsageError, match="not a folder"):
        priors.photographs(tmp_path / "none")
