"""Files of other tools that hold a rig: cameras, and where they are to each other.

Each camera is written as `calibsolver.formats` writes it, converted where a tool lacks its model. Poses are
x -> R x + t from camera 0 (or, in Kalibr's chain, from the camera before) to a camera, in the rig's unit.
"""

import io
import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import formats, rotation
from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from ..formats import colmap, kalibr, opencv, ros, text, web
from ..formats.base import MAX_INVISIBLE_PX, Conversion, ExportedFile, ExportSource
from ..formats.format import Format
from ..formats.photonvision import quaternion
from .rectification import Rectification, rectify
from .start import RigidMotion

ZIP_TIME = (1980, 1, 1, 0, 0, 0)
"""Time of the members of an archive: equal rigs make equal files."""


@dataclass(frozen=True, eq=False)
class RigSource:
    """Rig to be written.

    Attributes
    ----------
    cameras
        By position.
    poses
        (c, 6) rvec|tvec, camera 0 -> camera i.
    unit
        Unit of the translations: ``squares`` or ``metres``.
    names
        Labels of the cameras; empty: their numbers.
    identifier
        The rig's id, or "".
    record
        All that the service answers about it.
    """

    cameras: Sequence[Camera]
    poses: Array
    unit: str = "squares"
    names: Sequence[str] = ()
    identifier: str = ""
    record: Mapping[str, Any] = field(default_factory=dict)

    def motion(self, position: int) -> RigidMotion:
        """Motion camera 0 -> a camera."""
        return RigidMotion.of_vector(np.asarray(self.poses[position]))

    def name(self, position: int) -> str:
        """Label of a camera."""
        return self.names[position] if self.names else f"cam{position}"


def write(source: RigSource, name: str) -> ExportedFile:
    """Write a rig as the format called `name`: one file, or a zip archive of several.

    Raises CalibrationError ``unknown_format``, or ``not_representable`` where the format cannot hold it.
    """
    writer = WRITERS.get(name)
    if writer is None:
        raise CalibrationError(
            "unknown_format", f"no format of rigs is called {name!r}; there are {', '.join(WRITERS)}"
        )
    files = writer(source)
    stem = f"{formats.slug(source.identifier) if source.identifier else 'rig'}-{name}"
    if len(files.files) == 1:
        (filename, content), *_ = files.files.items()
        return ExportedFile(content, files.media_type, f"{stem}-{filename}", files.error, 1.0, files.warning)
    return ExportedFile(
        _archive(files.files), "application/zip", f"{stem}.zip", files.error, 1.0, files.warning
    )


@dataclass(frozen=True)
class _RigFiles:
    """Files by name, and the largest error of a converted camera, px."""

    files: dict[str, bytes]
    media_type: str
    error: float = 0.0

    @property
    def warning(self) -> str | None:
        return (
            f"Approximation: up to {self.error:.2f} px off somewhere in an image."
            if self.error > MAX_INVISIBLE_PX
            else None
        )


def _archive(files: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for filename, content in files.items():
            archive.writestr(zipfile.ZipInfo(filename, ZIP_TIME), content, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _convert(source: RigSource, form: Format) -> list[tuple[ExportSource, Conversion]]:
    """Convert the cameras to those that a format can hold."""
    conversions = []
    for i, camera in enumerate(source.cameras):
        single = ExportSource(camera, name=source.name(i), identifier=source.identifier)
        try:
            conversions.append((single, form.check(form.convert(single))))
        except CalibrationError as error:
            raise CalibrationError(error.code, f"camera {i}: {error.message}") from error
    return conversions


def _worst(converted: Sequence[tuple[ExportSource, Conversion]]) -> float:
    return max(conversion.error for _, conversion in converted)


def _opencv(source: RigSource) -> _RigFiles:
    """Stereo YAML of camera 0 and each other camera, with the matrices that cv2.stereoRectify returns."""
    converted = _convert(source, opencv.OpenCvYaml())
    files = {}
    for i in range(1, len(source.cameras)):
        one, other = converted[0][1].camera, converted[i][1].camera
        motion = source.motion(i)
        essential = rotation.skew(motion.t) @ motion.r
        k1, k2 = np.asarray(one.matrix), np.asarray(other.matrix)
        fundamental = np.linalg.inv(k2).T @ essential @ np.linalg.inv(k1)
        if abs(fundamental[2, 2]) > 0:
            fundamental = fundamental / fundamental[2, 2]
        members: dict[str, Array] = {}
        for side, conversion in (("1", converted[0][1]), ("2", converted[i][1])):
            for key, value in opencv.matrices(conversion).items():
                members[{"camera_matrix": "K", "distortion_coefficients": "D", "xi": "xi"}[key] + side] = (
                    value
                )
        members |= {"R": motion.r, "T": motion.t[:, None], "E": essential, "F": fundamental}
        if rectification := _rectification(one, other, motion):
            members |= {name: getattr(rectification, name.lower()) for name in ("R1", "R2", "P1", "P2", "Q")}
        body = [
            f"image_width: {one.img_size[0]}",
            f"image_height: {one.img_size[1]}",
            f"image_width2: {other.img_size[0]}",
            f"image_height2: {other.img_size[1]}",
            f"fisheye_model: {int(one.model == 'fisheye')}",
            f"fisheye_model2: {int(other.model == 'fisheye')}",
            f"unit: {text.quote(source.unit)}",
        ]
        for key, value in members.items():
            body += opencv.yaml_matrix(key, value)
        files[f"stereo-0-{i}.yml"] = text.lines("%YAML:1.0", "---", body)
    return _RigFiles(files, "application/yaml", _worst(converted))


def _ros(source: RigSource) -> _RigFiles:
    """CameraInfo YAML of each camera; of two cameras rectified, as stereo_image_proc wants it."""
    form = ros.Ros()
    converted = _convert(source, form)
    rectification = None
    if len(source.cameras) == 2:
        rectification = _rectification(converted[0][1].camera, converted[1][1].camera, source.motion(1))
    files = {}
    for i, (single, conversion) in enumerate(converted):
        if rectification is None:
            content = form.write(single, conversion)
        else:
            r, p = ((rectification.r1, rectification.p1), (rectification.r2, rectification.p2))[i]
            content = form.write_rectified(single, conversion, r, p)
        files[f"{('left', 'right')[i] if len(source.cameras) == 2 else f'cam{i}'}.yaml"] = content
    return _RigFiles(files, "application/yaml", _worst(converted))


def _kalibr(source: RigSource) -> _RigFiles:
    """Camchain: each camera with the pose from the one before it, T_cn_cnm1."""
    form = kalibr.Kalibr()
    converted = _convert(source, form)
    parts = []
    for i, (single, conversion) in enumerate(converted):
        chain = form.write(single, conversion).decode()
        chain = chain.replace("cam0:", f"cam{i}:").replace("/cam0/", f"/cam{i}/")
        if i:
            step = source.motion(i) @ source.motion(i - 1).inverse()
            rows = [*np.column_stack([step.r, step.t]), (0.0, 0.0, 0.0, 1.0)]
            chain += "  T_cn_cnm1:\n" + "".join(f"  - [{text.numbers(row)}]\n" for row in rows)
        parts.append(chain)
    note = f"# translations in {source.unit}\n"
    return _RigFiles(
        {"camchain.yaml": (note + "".join(parts)).encode()}, "application/yaml", _worst(converted)
    )


def _colmap(source: RigSource) -> _RigFiles:
    """cameras.txt and rig_config.json; its poses are those of cameras in the rig, camera 0 the reference."""
    form = colmap.Colmap()
    converted = _convert(source, form)
    rows, cameras = [], []
    for i, (single, conversion) in enumerate(converted):
        line = form.write(single, conversion).decode().strip().splitlines()[-1].split()
        rows.append(" ".join([str(i + 1), *line[1:]]))
        entry: dict[str, Any] = {
            "image_prefix": f"cam{i}/",
            "camera_model_name": line[1],
            "camera_params": [float(value) for value in line[4:]],
        }
        if i:
            motion = source.motion(i)
            entry["cam_from_rig_rotation"] = quaternion(motion.vector()[:3]).tolist()
            entry["cam_from_rig_translation"] = motion.t.tolist()
        else:
            entry["ref_sensor"] = True
        cameras.append(entry)
    head = [
        "# Camera list with one line of data per camera:",
        "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]",
    ]
    return _RigFiles(
        {
            "cameras.txt": text.lines(head, rows),
            "rig_config.json": (json.dumps([{"cameras": cameras}], indent=2) + "\n").encode(),
        },
        "text/plain; charset=utf-8",
        _worst(converted),
    )


def _mrcal(source: RigSource) -> _RigFiles:
    """Model of each camera, `rt_cam_ref` the pose from camera 0."""
    form = formats.FORMATS["mrcal"]
    converted = _convert(source, form)
    files = {}
    for i, (single, conversion) in enumerate(converted):
        pose = f"[ {text.numbers(source.poses[i])}]"
        content = form.write(single, conversion).decode()
        files[f"cam{i}.cameramodel"] = content.replace("[ 0, 0, 0, 0, 0, 0,]", pose).encode()
    return _RigFiles(files, "text/plain; charset=utf-8", _worst(converted))


def _gltf(source: RigSource) -> _RigFiles:
    """Scene with a node for each camera; glTF's cameras look along -z with y up."""
    form = web.Gltf()
    flip = np.diag([1.0, -1.0, -1.0])
    cameras, nodes = [], []
    for i, camera in enumerate(source.cameras):
        single = ExportSource(camera, name=source.name(i))
        cameras.append(json.loads(form.write(single, form.convert(single)))["cameras"][0])
        back = source.motion(i).inverse()
        turn = flip @ back.r @ flip
        w, x, y, z = quaternion(rotation.vector(turn)).tolist()
        place = (flip @ back.t).tolist()
        nodes.append({"name": source.name(i), "camera": i, "rotation": [x, y, z, w], "translation": place})
    scene = {
        "asset": {"version": "2.0", "generator": "calibDB", "extras": {"unit": source.unit}},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "cameras": cameras,
    }
    return _RigFiles({"rig.gltf": text.dump(scene)}, "model/gltf+json")


def _json(source: RigSource) -> _RigFiles:
    """Record of the service."""
    return _RigFiles({"rig.json": text.dump(source.record)}, "application/json")


def _rectification(one: Camera, other: Camera, motion: RigidMotion) -> Rectification | None:
    """Rectification of two cameras; None if there is none that tools know."""
    try:
        return rectify(one, other, motion)
    except CalibrationError:
        return None


WRITERS: Mapping[str, Callable[[RigSource], _RigFiles]] = {
    "json": _json,
    "opencv-yaml": _opencv,
    "ros": _ros,
    "kalibr": _kalibr,
    "colmap": _colmap,
    "mrcal": _mrcal,
    "gltf": _gltf,
}
"""Writers of rigs by the names of their formats."""
