"""Files of rigs for other tools.

Each camera is written as `calibsolver.formats` writes it. Poses are x -> R x + t from camera 0 (in Kalibr's
chain from the camera before) to a camera, in the rig's unit.
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
"""Equal rigs make equal files."""


@dataclass(frozen=True, eq=False)
class RigSource:
    """Rig to be written.

    Attributes
    ----------
    poses
        (c, 6) rvec|tvec, camera 0 -> camera i.
    unit
        Unit of the translations: ``squares`` or ``metres``.
    names
        Labels of the cameras; empty: their numbers.
    record
        The service's answer about it, which the format ``json`` contains.
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


@dataclass(frozen=True)
class _Converted:
    source: ExportSource
    conversion: Conversion
    form: Format

    def text(self) -> str:
        return self.form.write(self.source, self.conversion).decode()


Files = dict[str, bytes]
Writer = Callable[[RigSource, Sequence[_Converted]], Files]


def write(source: RigSource, name: str) -> ExportedFile:
    """Write a rig as the format called `name`: one file, or a zip archive of several.

    Raises CalibrationError ``unknown_format`` or ``not_representable``.
    """
    if name not in WRITERS:
        raise CalibrationError(
            "unknown_format", f"no format of rigs is called {name!r}; there are {', '.join(WRITERS)}"
        )
    form, writer, media_type = WRITERS[name]
    converted = [] if form is None else _convert(source, form)
    files = writer(source, converted)
    error = max((each.conversion.error for each in converted), default=0.0)
    warning = None
    if error > MAX_INVISIBLE_PX:
        warning = f"Approximation: up to {error:.2f} px off somewhere in an image."
    stem = f"{formats.slug(source.identifier) if source.identifier else 'rig'}-{name}"
    if len(files) == 1:
        (filename, content), *_ = files.items()
        return ExportedFile(content, media_type, f"{stem}-{filename}", error, 1.0, warning)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for filename, content in files.items():
            archive.writestr(zipfile.ZipInfo(filename, ZIP_TIME), content, zipfile.ZIP_DEFLATED)
    return ExportedFile(packed.getvalue(), "application/zip", f"{stem}.zip", error, 1.0, warning)


def _convert(source: RigSource, form: Format) -> list[_Converted]:
    converted = []
    for i, camera in enumerate(source.cameras):
        single = ExportSource(camera, name=source.name(i), identifier=source.identifier)
        try:
            converted.append(_Converted(single, form.check(form.convert(single)), form))
        except CalibrationError as error:
            raise CalibrationError(error.code, f"camera {i}: {error.message}") from error
    return converted


def _opencv(source: RigSource, converted: Sequence[_Converted]) -> Files:
    """Stereo YAML of camera 0 and each other camera, as of cv2.stereoRectify."""
    short = {"camera_matrix": "K", "distortion_coefficients": "D", "xi": "xi"}
    files = {}
    for i in range(1, len(source.cameras)):
        pair = converted[0].conversion, converted[i].conversion
        one, other = (conversion.camera for conversion in pair)
        motion = source.motion(i)
        essential = rotation.skew(motion.t) @ motion.r
        k1, k2 = np.asarray(one.matrix), np.asarray(other.matrix)
        fundamental = np.linalg.inv(k2).T @ essential @ np.linalg.inv(k1)
        if abs(fundamental[2, 2]) > 0:
            fundamental = fundamental / fundamental[2, 2]
        members: dict[str, Array] = {}
        for side, conversion in enumerate(pair, start=1):
            for key, value in opencv.matrices(conversion).items():
                members[f"{short[key]}{side}"] = value
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
    return files


def _ros(source: RigSource, converted: Sequence[_Converted]) -> Files:
    """CameraInfo YAML of each camera; of two cameras rectified, as stereo_image_proc requires."""
    if len(converted) != 2:
        return {f"cam{i}.yaml": each.text().encode() for i, each in enumerate(converted)}
    left, right = converted
    found = _rectification(left.conversion.camera, right.conversion.camera, source.motion(1))
    if found is None:
        return {"left.yaml": left.text().encode(), "right.yaml": right.text().encode()}
    return {
        "left.yaml": ROS.write_rectified(left.source, left.conversion, found.r1, found.p1),
        "right.yaml": ROS.write_rectified(right.source, right.conversion, found.r2, found.p2),
    }


def _kalibr(source: RigSource, converted: Sequence[_Converted]) -> Files:
    """Camchain: each camera with the pose from the one before it, T_cn_cnm1."""
    parts = [f"# translations in {source.unit}\n"]
    for i, each in enumerate(converted):
        chain = each.text().replace("cam0:", f"cam{i}:").replace("/cam0/", f"/cam{i}/")
        if i:
            step = source.motion(i) @ source.motion(i - 1).inverse()
            rows = [*np.column_stack([step.r, step.t]), (0.0, 0.0, 0.0, 1.0)]
            chain += "  T_cn_cnm1:\n" + "".join(f"  - [{text.numbers(row)}]\n" for row in rows)
        parts.append(chain)
    return {"camchain.yaml": "".join(parts).encode()}


def _colmap(source: RigSource, converted: Sequence[_Converted]) -> Files:
    """cameras.txt and rig_config.json, camera 0 the reference."""
    rows, cameras = [], []
    for i, each in enumerate(converted):
        line = each.text().strip().splitlines()[-1].split()
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
    return {
        "cameras.txt": text.lines(head, rows),
        "rig_config.json": (json.dumps([{"cameras": cameras}], indent=2) + "\n").encode(),
    }


def _mrcal(source: RigSource, converted: Sequence[_Converted]) -> Files:
    """Model of each camera, `rt_cam_ref` the pose from camera 0."""
    files = {}
    for i, each in enumerate(converted):
        pose = f"[ {text.numbers(source.poses[i])}]"
        files[f"cam{i}.cameramodel"] = each.text().replace("[ 0, 0, 0, 0, 0, 0,]", pose).encode()
    return files


def _gltf(source: RigSource, _: Sequence[_Converted]) -> Files:
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
    return {"rig.gltf": text.dump(web.scene(nodes, cameras, extras={"unit": source.unit}))}


def _json(source: RigSource, _: Sequence[_Converted]) -> Files:
    return {"rig.json": text.dump(source.record)}


def _rectification(one: Camera, other: Camera, motion: RigidMotion) -> Rectification | None:
    try:
        return rectify(one, other, motion)
    except CalibrationError:
        return None


ROS = ros.Ros()
PLAIN_TEXT = "text/plain; charset=utf-8"
WRITERS: Mapping[str, tuple[Format | None, Writer, str]] = {
    "json": (None, _json, "application/json"),
    "opencv-yaml": (opencv.OpenCvYaml(), _opencv, "application/yaml"),
    "ros": (ROS, _ros, "application/yaml"),
    "kalibr": (kalibr.Kalibr(), _kalibr, "application/yaml"),
    "colmap": (colmap.Colmap(), _colmap, PLAIN_TEXT),
    "mrcal": (formats.FORMATS["mrcal"], _mrcal, PLAIN_TEXT),
    "gltf": (None, _gltf, "model/gltf+json"),
}
"""Per format: that of one camera to which cameras are converted, writer, media type of a single file."""
