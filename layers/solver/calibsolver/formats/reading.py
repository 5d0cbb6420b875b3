"""Readers of other tools' files, by their kind."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from . import (
    artoolkit,
    colmap,
    document,
    foreign_models,
    mrcal,
    native,
    plain_values,
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
    names = tuple(name for name, _ in cameras)
    if not 0 <= options.number < len(cameras):
        raise text.refuse(
            f"there is no camera {options.number}: the file has {len(cameras)}, counted from 0 "
            f"({', '.join(name or 'unnamed' for name in names[:8])})"
        )
    imported = cameras[options.number][1](options)
    if imported.camera and options.img_size and imported.camera.img_size != options.img_size:
        w, h = imported.camera.img_size
        passed = " x ".join(map(str, options.img_size))
        raise text.refuse(f"the file says that its pictures are {w} x {h}, not {passed}")
    return replace(imported, cameras=names if len(names) > 1 else ())


def read_bytes(
    raw: bytes,
    suffix: str = "",
    options: ReaderOptions = ReaderOptions(),  # noqa: B008 - a value that never changes
) -> ImportedFile:
    """Read a whole file of any kind, with limits on what it may hold; `suffix` as of its name.

    Raises CalibrationError ``malformed``. YAML needs the package PyYAML.
    """
    try:
        return _read_bytes(raw, suffix, options)
    except RecursionError:
        raise text.refuse("nested too deeply") from None
    except MemoryError:  # an array that claims a size of its own choice
        raise text.refuse("an array in it is too large") from None


def _read_bytes(raw: bytes, suffix: str, options: ReaderOptions) -> ImportedFile:
    from . import untrusted

    if raw.startswith(b"PK\x03\x04"):
        return read(plain_values.archive(raw), options)
    if artoolkit.is_parameters(raw):
        return artoolkit.read(raw)
    content = untrusted.decode(raw)
    if content.lstrip()[:1] in ("{", "["):
        parsed = untrusted.parse_json(content, suffix)
        if parsed is not None:
            return read(parsed, options)
    for recognise, reader in _TEXT_READERS:
        if recognise(content):
            return reader(content, options)
    if suffix != ".vnl" and not mrcal.is_corners(content):
        return read(untrusted.parse_yaml(content), options)
    if options.squares is None:
        raise text.refuse(
            "a table of corners does not say what board it is of: give its squares (--squares 9x6), one more "
            "each way than there are corners"
        )
    return mrcal.read_corners(content, options.squares)


def _of_values(parse: Callable[[str], object]) -> Callable[[str, ReaderOptions], ImportedFile]:
    return lambda content, options: read(parse(content), options)


_TEXT_READERS: Sequence[tuple[Callable[[str], Any], Callable[[str, ReaderOptions], ImportedFile]]] = (
    (foreign_models.is_ocamcalib, lambda content, _: foreign_models.read_ocamcalib(content)),
    (lambda content: content.lstrip().startswith("<"), _of_values(plain_values.xml)),
    (mrcal.is_model, lambda content, _: mrcal.read(content)),
    (plain_values.is_ros_ini, _of_values(plain_values.ros_ini)),
    (colmap.lines_of_cameras, _of_values(colmap.lines_of_cameras)),
    (plain_values.is_assignments, _of_values(plain_values.assignments)),
    (plain_values.numbers_alone, _of_values(plain_values.numbers_alone)),
)
"""Recognisers of texts other than JSON and YAML, each with its reader; the first that matches reads."""
