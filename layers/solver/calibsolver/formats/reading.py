"""Other tools' files read: what kind one is, and what it says."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from . import (
    artoolkit,
    colmap,
    document,
    mrcal,
    native,
    numpy_archive,
    ocamcalib,
    plain_text,
    storage_xml,
    text,
)
from .base import ImportedFile, ReaderOptions


def read(data: object, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: B008 - a value that never changes
    """Read a camera of parsed JSON, YAML, XML or other structure, whichever of the known kinds it is.

    Raises CalibrationError ``malformed``, which says what is missing or wrong.
    """
    if isinstance(data, Mapping) and {"img_size", "camera_matrix", "distortion_coefficients"} <= data.keys():
        return native.read(data)
    cameras = document.cameras(data)
    if not cameras:
        raise document.describe_unknown(data)
    if not 0 <= options.number < len(cameras):
        raise text.refuse(
            f"there is no camera {options.number}: the file has {len(cameras)}, counted from 0 "
            f"({', '.join(each.name or 'unnamed' for each in cameras[:8])})"
        )
    read_camera = cameras[options.number]
    imported = read_camera.read(options)
    if imported.camera and options.img_size and imported.camera.img_size != options.img_size:
        w, h = imported.camera.img_size
        passed = " x ".join(map(str, options.img_size))
        raise text.refuse(f"the file says that its pictures are {w} x {h}, not {passed}")
    names = tuple(each.name for each in cameras) if len(cameras) > 1 else ()
    return replace(imported, cameras=names)


def read_bytes(
    raw: bytes,
    suffix: str = "",
    options: ReaderOptions = ReaderOptions(),  # noqa: B008 - a value that never changes
) -> ImportedFile:
    """Read a whole file of any kind, with limits on what it may hold; `suffix` as of its name.

    Raises CalibrationError ``malformed``, which says what is missing or wrong. YAML needs the package PyYAML.
    """
    from . import untrusted

    try:
        parsed = untrusted.parse(raw, suffix, is_text_kind)
        return READERS[parsed.form](parsed.content, options)
    except RecursionError:
        raise text.refuse("nested too deeply") from None
    except MemoryError:  # an array that claims a size of its own choice
        raise text.refuse("an array in it is too large") from None


def is_text_kind(content: str) -> bool:
    """True if `read_text` reads it: it is neither JSON nor YAML."""
    return (
        content.lstrip().startswith("<")
        or is_mrcal(content)
        or plain_text.is_ros_ini(content)
        or bool(colmap.lines_of_cameras(content))
        or plain_text.is_assignments(content)
        or plain_text.numbers_alone(content) is not None
        or ocamcalib.is_results(content)
        or mrcal.is_corners(content)
    )


def is_mrcal(content: str) -> bool:
    """True if it is a .cameramodel: a Python dictionary with a lens model, under today's or an older name."""
    return any(
        f"{quote}{name}{quote}" in content
        for name in ("lensmodel", "lens_model", "distortion_model")
        for quote in ("'",)
    ) or ('"lensmodel":  ' in content)


def read_text(content: str, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: B008 - a value that never changes
    """Read a text of another form: XML, mrcal's .cameramodel, ROS's .ini and ost.txt, COLMAP's cameras.txt,
    `name = value` lines, a bare matrix of numbers, or a table of corners.

    Raises CalibrationError ``malformed``.
    """  # noqa: D205 - a list of names
    if ocamcalib.is_results(content):
        return ocamcalib.read(content)
    if content.lstrip().startswith("<"):
        return read(storage_xml.parse(content), options)
    if is_mrcal(content):
        return mrcal.read(content)
    if plain_text.is_ros_ini(content):
        return read(plain_text.ros_ini(content), options)
    if cameras := colmap.lines_of_cameras(content):
        return read(cameras, options)
    if plain_text.is_assignments(content):
        return read(plain_text.assignments(content), options)
    if camera := plain_text.numbers_alone(content):
        return read(camera, options)
    if options.squares is None:
        raise text.refuse(
            "a table of corners does not say what board it is of: give its squares (--squares 9x6), one more "
            "each way than there are corners"
        )
    return mrcal.read_corners(content, options.squares)


def read_archive(raw: bytes, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: B008 - a value that never changes
    """Read an archive of numpy arrays (.npz); CalibrationError ``malformed``."""
    return read(numpy_archive.parse(raw), options)


def read_binary(raw: bytes, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: ARG001, B008
    """Read ARToolKit's camera_para.dat; CalibrationError ``malformed``."""
    return artoolkit.read(raw)


READERS: Mapping[str, Callable[[Any, ReaderOptions], ImportedFile]] = {
    "values": read,
    "text": read_text,
    "archive": read_archive,
    "binary": read_binary,
}
"""Readers by the form of a file's content."""
