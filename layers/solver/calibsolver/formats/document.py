"""Search of a parsed file for the cameras that it holds, however they are nested."""

import re
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import islice
from typing import Any

from ..errors import CalibrationError
from . import agisoft, colmap, generic, gyroflow, kalibr, lensfun, meshroom, opensfm, photonvision, text
from .base import ImportedFile, ReaderOptions
from .members import DISTORTION, MATRIX, Members, image_size, normalise, words

MAX_DEPTH = 8
MAX_CAMERAS = 200
FILE_SUFFIXES = (".yaml", ".yml", ".xml", ".json", ".ini", ".txt")
MAX_PATH_LENGTH = 300


FoundCamera = tuple[str, Callable[[ReaderOptions], ImportedFile]]
"""Path of names to a camera in a file, and its reader, which raises CalibrationError ``malformed``."""


def cameras(data: object) -> list[FoundCamera]:
    """Return the cameras of a parsed file in its order; `cam0`, `cam1` … in that of their numbers."""
    records = list(islice(_walk(data, (), (), 0), MAX_CAMERAS))
    numbers = [re.fullmatch(r"cam(?:era)?_?(\d{1,9})", name) for name, _ in records]
    order = sorted((int(match[1]), i) for i, match in enumerate(numbers) if match)
    return [records[i] for _, i in order] if len(order) == len(records) else records


def _walk(
    data: object, path: tuple[str, ...], around: tuple[Members, ...], index: int
) -> Iterator[FoundCamera]:
    """Find cameras below `data`, at `path` and, in a list, at `index`; `around`: what it stands in."""
    if len(path) > MAX_DEPTH:
        return
    if isinstance(data, list | tuple):
        if data and isinstance(data[0], Mapping | list | tuple):
            for i, item in enumerate(data[:MAX_CAMERAS]):
                yield from _walk(item, (*path, str(i)), around, i)
        return
    if not isinstance(data, Mapping):
        return
    members = Members(data)
    name = ".".join(path)
    reader = _reader(data, members)
    sides = _sides(members)
    around = (*around, members)
    if lensfun.is_lens(members):
        for part in lensfun.distortions(data):
            yield lensfun.lens_name(data, part), partial(lensfun.read, data, part)
        return
    if reader is not None:
        yield name, lambda _: reader(data)
    elif len(sides) > 1 or (sides and not generic.is_camera(members)):
        for side, part in sides.items():
            yield ".".join((*path, side)), _generic(part, around, index)
    elif generic.is_camera(members):
        yield name, _generic(data, around, index)
    else:
        for key, value in _nest_dotted_names(data).items():
            yield from _walk(value, (*path, key), around, 0)


def _generic(
    data: Mapping[Any, Any], around: tuple[Members, ...], index: int
) -> Callable[[ReaderOptions], ImportedFile]:
    def read(options: ReaderOptions) -> ImportedFile:
        sizes = (_size(members, index) for members in reversed(around))
        return generic.read(data, options, next((size for size in sizes if size), None))

    return read


def _reader(data: Mapping[Any, Any], members: Members) -> Callable[[Any], ImportedFile] | None:
    """Return the reader of a tool's own structure, if the mapping has it."""
    if "fisheye_params" in data:
        return gyroflow.read
    if text.has_member(data.get("cameraIntrinsics"), "data"):
        return photonvision.read
    if "projection_type" in data and ("focal" in data or "focal_x" in data):
        return opensfm.read
    if "colmap_model" in data:
        return colmap.read
    if "camera_model" in data and "intrinsics" in data and "resolution" in data:
        return kalibr.read
    if agisoft.is_calibration(members):
        return agisoft.read
    if agisoft.is_sensor(members):
        return agisoft.read_sensor
    if meshroom.is_intrinsic(members):
        return meshroom.read
    return None


def _size(members: Members, index: int) -> tuple[int, int] | None:
    """Image size next to cameras: among the members, or one level below."""
    candidates = [members, *(Members(value) for _, value in members.items() if isinstance(value, Mapping))]
    for each in candidates:
        try:
            result = image_size(each, index)
        except CalibrationError:
            continue
        if result and min(result) >= 16:  # squares of a board are fewer
            return result
    return None


def _sides(members: Members) -> dict[str, dict[str, Any]]:
    """Cameras whose members differ by a number or a side: M1 D1 M2 D2, left_camera_matrix, K_right."""
    groups: dict[str, dict[str, Any]] = {}
    for key, value in members.items():
        for base, side in _stems(key):
            if base in MATRIX and generic.is_camera(Members({base: value})):
                groups.setdefault(side, {})[base] = value
                break
    for key, value in members.items():
        for base, side in _stems(key):
            if side in groups and (
                base in DISTORTION or base in ("imagesize", "size", "resolution", "s", "xi")
            ):
                groups[side].setdefault("image_size" if base == "s" else base, value)
                break
    common = {
        key: value for key, value in members.items() if not isinstance(value, Mapping) and key in _SHARED
    }
    return {side: {**common, **group} for side, group in groups.items()}


_SHARED = words("imagewidth imageheight imagesize width height resolution imgsize distortionmodel fisheye")


def _stems(key: str) -> Iterator[tuple[str, str]]:
    """Split a normalised name into what it names and the side or number, wherever that stands."""
    for side in ("left", "right", "front", "rear", "rgb", "depth", "color", "ir"):
        if key.startswith(side):
            yield key.removeprefix(side), side
        if key.endswith(side):
            yield key.removesuffix(side), side
    if match := re.fullmatch(r"(?:cam(?:era)?)?(\d{1,3})([a-z]+)|([a-z]+?)(?:cam(?:era)?)?(\d{1,3})", key):
        yield match[2] or match[3], match[1] or match[4]
    if key[-1:] in ("l", "r"):
        yield key[:-1], {"l": "left", "r": "right"}[key[-1]]
    if key[:1] in ("l", "r"):
        yield key[1:], {"l": "left", "r": "right"}[key[0]]


def _nest_dotted_names(data: Mapping[Any, Any]) -> dict[str, Any]:
    """Gather members whose names are paths (`Camera1.fx` of ORB-SLAM) below the first part of the path."""
    nested: dict[str, Any] = {}
    shared = {}
    for key, value in data.items():
        head, dot, tail = str(key).partition(".")
        if not dot or not head or not tail:
            nested.setdefault(str(key), value)
            continue
        part = nested.setdefault(head, {})
        if isinstance(part, dict):
            part.setdefault(tail, value)
        if head.lower() == "camera" and normalise(tail) in ("type", "width", "height"):
            shared[tail] = value
    for key, part in nested.items():
        if shared and isinstance(part, dict) and re.fullmatch(r"camera\d*", key.lower()):
            for name, value in shared.items():
                part.setdefault(name, value)
    return nested


def describe_unknown(data: object) -> CalibrationError:
    """Return the error of a file without a camera: what it seems to be instead."""
    if not isinstance(data, Mapping) and not (isinstance(data, list) and data):
        return text.refuse("the file is not an object with members")
    flat = data if isinstance(data, Mapping) else {}
    names = {normalise(key) for key, _ in _leaves(flat)}
    if {"boardsizewidth", "calibratepattern"} & names or {"targettype", "tagsize"} & names:
        return text.refuse(
            "the file holds the settings of a calibration program (its board), not a calibration"
        )
    strings = [(k, v) for k, v in _leaves(flat) if isinstance(v, str) and len(v) <= MAX_PATH_LENGTH]
    for key, value in strings:
        path, place = value.strip(), (key + value).lower()
        if path.endswith(FILE_SUFFIXES) and any(word in place for word in ("cam", "intrin", "calib")):
            return text.refuse(f"the file holds no camera; it names another one: {path[:100]} ({key[:40]})")
    members = ", ".join(str(key)[:30] for key in list(flat)[:6])
    return text.refuse(
        "the file is of no kind that is known here: it has no camera matrix, nor focal lengths and a centre"
        + (f"; its members are {members}" if members else "")
    )


def _leaves(data: Mapping[Any, Any], depth: int = 0) -> Iterator[tuple[str, Any]]:
    for key, value in list(data.items())[:1000]:
        if isinstance(value, Mapping) and depth < 3:
            yield from _leaves(value, depth + 1)
        else:
            yield str(key), value
