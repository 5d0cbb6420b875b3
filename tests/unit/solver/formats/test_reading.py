"""Files read back are what was written, and files that make no sense are refused with a reason."""

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibsolver import CalibrationError, View, formats, models
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.grid import grid
from calibsolver.formats.reading import read, read_bytes
from infra.ops import OpsError
from infra.ops.imports import read_file
from tests.helpers.data import corner_set, corner_views
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver.export_sources import IMG_SIZE, subject, written

READABLE = {
    "calibdb": ".json",
    "opencv-yaml": ".yml",
    "opencv-json": ".json",
    "ros": ".yaml",
    "kalibr": ".yaml",
    "mrcal": ".cameramodel",
    "gyroflow": ".json",
    "photonvision": ".json",
}


@pytest.mark.parametrize("model", ["rectilinear", "fisheye", *thorough("rational", "omnidirectional")])
@pytest.mark.parametrize("name", READABLE)
def test_written_files_round_trip(tmp_path: Path, name: str, model: str) -> None:
    mine, path = subject(model), tmp_path / f"camera{READABLE[name]}"
    path.write_bytes(written(model, name).content)
    held = formats.FORMATS[name].convert(mine).camera
    found = read_file(path)
    assert found.camera is not None
    assert found.camera.model == held.model
    assert found.camera.img_size == IMG_SIZE
    assert np.allclose(found.camera.intrinsics, held.intrinsics, rtol=1e-9, atol=0)
    if name in ("mrcal", "photonvision"):
        same_keypoints(found.views, mine.views)


def same_keypoints(found: tuple[View, ...], sent: tuple[View, ...]) -> None:
    recognised = grid(found)
    assert recognised.squares == (9, 6)
    assert len(found) == len(sent)
    for ids, back, view in zip(recognised.ids, found, sent, strict=True):
        p = np.array([[i % 8 + 1, i // 8 + 1] for i in ids])
        assert np.array_equal(p, view.object_points[:, :2])
        assert np.array_equal(back.image_points, view.image_points)


def test_table_of_corners_is_read(tmp_path: Path) -> None:
    path = tmp_path / "corners.vnl"
    path.write_bytes(written("fisheye", "corners-vnl").content)
    same_keypoints(read_file(path, ReaderOptions(squares=(9, 6))).views, subject("fisheye").views)
    with pytest.raises(OpsError, match="squares"):
        read_file(path)
    with pytest.raises(OpsError, match="70 lines"):
        read_file(path, ReaderOptions(squares=(11, 8)))


@pytest.mark.parametrize("unit", [0.0254, 25.4, 3.0])
def test_board_is_recognised_in_any_unit_from_any_corner(unit: float) -> None:
    sent = subject("rectilinear").views
    moved = [View((v.object_points - (1, 1, 0)) * unit + (7, -2, 0), v.image_points) for v in sent]
    assert grid(moved) == grid(sent)
    bent = [View(v.object_points + (0, 0, 0.2) * (v.object_points[:, :1] > 4), v.image_points) for v in sent]
    with pytest.raises(CalibrationError, match="flat"):
        grid(bent)
    scattered = [View(v.object_points * (1, 1.07, 0), v.image_points) for v in sent]
    with pytest.raises(CalibrationError, match="rows and columns"):
        grid(scattered)


def test_gyroflow_profile_without_flag_has_a_centred_axis() -> None:
    data = json.loads(written("fisheye", "gyroflow").content)
    del data["asymmetrical"]
    camera = read(data).camera
    assert camera is not None
    assert camera.matrix[:2, 2].tolist() == [640.0, 360.0]


SQUARES = {"opencv_left": (10, 7), "pv_charuco_1280": (8, 8)}


@pytest.mark.parametrize("name", corner_sets(SQUARES))
def test_corners_of_real_photographs_match_their_board(name: str) -> None:
    held = corner_set(name)["views"]
    recognised = grid(tuple(corner_views(name)[0]))
    assert recognised.squares == SQUARES[name]
    expected = [list(v.get("ids", range(len(v["obj"])))) for v in held]
    assert [list(ids) for ids in recognised.ids] == expected


def test_malformed_files_are_refused_with_a_reason(tmp_path: Path) -> None:
    good = json.loads(written("rectilinear", "photonvision").content)
    for member, value, reason in (
        ("resolution", {"width": 1280}, "resolution.height"),
        ("resolution", {"width": 1e9, "height": 720}, "resolution.width"),
        ("cameraIntrinsics", {"data": [1, 2, 3]}, "9 to 9 numbers"),
        ("cameraIntrinsics", {"data": ["a"] * 9}, "must be numbers"),
        ("cameraIntrinsics", {"data": [0.0] * 9}, "positive"),
        ("distCoeffs", {"data": [0.1] * 12}, "thin prism"),
        ("observations", "many", "list"),
        ("observations", [{}] * 2000, "at most"),
        ("observations", [{"locationInObjectSpace": [{"x": 1}]}], "locationInObjectSpace|has no y"),
    ):
        with pytest.raises(CalibrationError, match=reason) as caught:
            read({**good, member: value})
        assert caught.value.code == "malformed"
    for content, reason in (
        ("{'lensmodel': 'LENSMODEL_CAHVOR', 'intrinsics': [1], 'imagersize': [1, 1]}", "none of"),
        ("{'lensmodel': __import__('os').getcwd()}", "not a Python dictionary"),
        ("'lensmodel'" + "(" * 5000, "not a Python dictionary"),
        (
            "{'lensmodel': 'LENSMODEL_OPENCV4', 'imagersize': [4, 4],"
            " 'intrinsics': [1, 1, 1, 1, 0, 0, 0, 1e999]}",
            "none of a",
        ),
        (
            "{'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [1, 1, 1, 1], 'imagersize': [4, 4],"
            " 'optimization_inputs': b'nonsense'}",
            "cannot be read",
        ),
    ):
        with pytest.raises(CalibrationError, match=reason):
            read_bytes(content.encode())
    native = '{"img_size": [1280, NaN], "camera_matrix": 0, "distortion_coefficients": 0}'
    for name, text, reason in (
        ("list.json", "[]", "not an object"),
        ("empty.json", "{}", "no kind"),
        ("bomb.yaml", "a: &a [1, 1]\nb: &b [*a, *a]\nc: [*b, *b]\n", "aliases"),
        ("deep.yaml", "a: " + "[" * 500 + "]" * 500, "nested too deeply"),
        ("deep.json", "[" * 100_000, "JSON|nested"),
        ("nan.json", native, "NaN"),
        ("nines.json", native.replace("NaN", "9" * 400), "a number"),
        ("tag.yaml", "!!python/object/apply:os.getcwd []", "not YAML"),
        ("date.yaml", "img_size: 2001-99-99", "cannot be read|not YAML|img_size"),
        ("cut.json", json.dumps(good)[:500], "not JSON"),
        ("large.yaml", "a: 1\n" * 300_000, "larger than"),
    ):
        path = tmp_path / name
        path.write_text(text)
        with pytest.raises(OpsError, match=reason):
            read_file(path)
    (tmp_path / "image.json").write_bytes(b"\x89PNG\r\n\xff\xfe")
    with pytest.raises(OpsError, match="no text"):
        read_file(tmp_path / "image.json")


@cache
def short(model: str, name: str) -> str:
    """File with the keypoints of two views."""
    mine = subject(model)
    return formats.write(replace(mine, views=mine.views[:2]), name).content.decode()


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_arbitrary_files_are_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Bytes of real files changed, cut, doubled: read, or refused with a reason; nothing else."""
    name = data.draw(st.sampled_from([*READABLE, "corners-vnl"]))
    content = short(data.draw(st.sampled_from(models.NAMES)), name)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content)))
        match data.draw(st.sampled_from(["cut", "insert", "number", "drop"])):
            case "cut":
                content = content[:at]
            case "insert":
                content = content[:at] + data.draw(st.text(max_size=8)) + content[at:]
            case "number":
                number = data.draw(st.sampled_from(["1e999", "-1", "nan", "9" * 400, '"x"', "[]", "null"]))
                content = content[:at] + re.sub(r"-?[0-9.]+", lambda _, n=number: n, content[at:], count=1)
            case "drop":
                content = content[:at] + content[at + data.draw(st.integers(1, 200)) :]
    path = tmp_path_factory.mktemp("fuzz") / f"file{READABLE.get(name, '.vnl')}"
    path.write_text(content, encoding="utf-8", errors="replace")
    try:
        found = read_file(path, ReaderOptions(squares=(9, 6)))
        if found.views:
            grid(found.views)
    except (OpsError, CalibrationError):
        pass
