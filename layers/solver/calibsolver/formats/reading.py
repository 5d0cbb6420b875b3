"""Other tools' files read: what kind one is, and what it says."""

from collections.abc import Callable, Mapping, Sequence
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
        form, content = untrusted.parse(raw, suffix, is_text_kind)
        return READERS[form](content, options)
    except RecursionError:
        raise text.refuse("nested too deeply") from None
    except MemoryError:  # an array that claims a size of its own choice
        raise text.refuse("an array in it is too large") from None


def is_text_kind(content: str) -> bool:
    """True if `read_text` reads it: it is neither JSON nor YAML."""
    return any(recognise(content) for recognise, _ in TEXT_READERS) or mrcal.is_corners(content)


def is_mrcal(content: str) -> bool:
    """True if it is a .cameramodel: a Python dictionary with a lens model, under today's or an older name."""
    names = ("lensmodel", "lens_model", "distortion_model")
    return any(f"'{name}'" in content for name in names) or '"lensmodel":  ' in content


def read_text(content: str, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: B008 - a value that never changes
    """Read a text of another form, one of `TEXT_READERS`, or else a table of corners.

    Raises CalibrationError ``malformed``.
    """
    for recognise, reader in TEXT_READERS:
        if recognise(content):
            return reader(content, options)
    if options.squares is None:
        raise text.refuse(
            "a table of corners does not say what board it is of: give its squares (--squares 9x6), one more "
            "each way than there are corners"
        )
    return mrcal.read_corners(content, options.squares)


def _of_values(parse: Callable[[Any], object]) -> Callable[[Any, ReaderOptions], ImportedFile]:
    """Return the reader of a content that is parsed to plain values."""
    return lambda content, options: read(parse(content), options)


TEXT_READERS: Sequence[tuple[Callable[[str], object], Callable[[str, ReaderOptions], ImportedFile]]] = (
    (ocamcalib.is_results, lambda content, _: ocamcalib.read(content)),
    (lambda content: content.lstrip().startswith("<"), _of_values(storage_xml.parse)),
    (is_mrcal, lambda content, _: mrcal.read(content)),
    (plain_text.is_ros_ini, _of_values(plain_text.ros_ini)),
    (colmap.lines_of_cameras, _of_values(colmap.lines_of_cameras)),
    (plain_text.is_assignments, _of_values(plain_text.assignments)),
    (plain_text.numbers_alone, _of_values(plain_text.numbers_alone)),
)
"""Recognisers of texts other than JSON and YAML, each with its reader; the first that matches reads."""
READERS: Mapping[str, Callable[[Any, ReaderOptions], ImportedFile]] = {
    "values": read,
    "text": read_text,
    "archive": _of_values(numpy_archive.parse),
    "binary": lambda raw, _: artoolkit.read(raw),
}
"""Readers by the form of a file's content."""
