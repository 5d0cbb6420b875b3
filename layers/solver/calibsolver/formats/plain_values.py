"""Plain values of files that are neither JSON nor YAML: arrays, XML, .ini, `name = value`, numbers."""

import io
import re
import xml.etree.ElementTree as ElementTree
import zipfile
from typing import Any

import numpy as np

from ..errors import CalibrationError
from . import text

MAX_ARCHIVE_BYTES = 64_000_000
MAX_ARRAY_NUMBERS = 100
"""Of an array that is looked at: a camera's are small."""


def archive(raw: bytes) -> dict[str, Any]:
    """Return the small arrays of a .npz as lists, without pickles; CalibrationError ``malformed``."""
    result: dict[str, Any] = {}
    pickled = []
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as files:
            if not all(info.filename.endswith(".npy") for info in files.infolist()):
                raise text.refuse("the file is a ZIP archive: unpack it and give the calibration file in it")
            if sum(info.file_size for info in files.infolist()) > MAX_ARCHIVE_BYTES:
                raise text.refuse("the archive is too large")
        with np.load(io.BytesIO(raw), allow_pickle=False) as arrays:
            for name in arrays.files:
                try:
                    array = arrays[name]
                except ValueError:
                    pickled.append(name)
                    continue
                if array.dtype.kind in "fiub" and array.size <= MAX_ARRAY_NUMBERS:
                    result[name] = array.tolist()
                elif array.dtype.kind == "U" and array.size == 1:
                    result[name] = str(array.item())[:200]
    except CalibrationError:
        raise
    except Exception as error:  # noqa: BLE001 - parsers of ZIP, deflate and Python raise a dozen types
        raise text.refuse(f"the file is not an archive of numpy arrays: {type(error).__name__}") from None
    if not result and pickled:
        raise text.refuse(
            f"the arrays {', '.join(pickled[:5])} are pickled objects, which may run code and are not read: "
            "save plain arrays"
        )
    return result


MAX_XML_DEPTH = 20
EXTERNAL_TYPE = re.compile(r"<!DOCTYPE\s+\w+\s+SYSTEM\s+(?:\"[^\"<>]{0,200}\"|'[^'<>]{0,200}')\s*>")
"""Document type in another file, without entities of its own."""


def xml(content: str) -> object:
    """Return the values below the root of XML, OpenCV's or another tool's elements and attributes.

    Raises CalibrationError ``malformed`` if it is not XML, or declares entities: those of a few hundred bytes
    can stand for gigabytes, or for other files.
    """
    start = content.find("?>") + 2 if content.lstrip().startswith("<?xml") else 0
    content = EXTERNAL_TYPE.sub("", content, count=1)  # nothing reads the file that it names
    if "<!DOCTYPE" in content or "<!ENTITY" in content:
        raise text.refuse("the XML declares entities, which calibration files do not need")
    try:
        root = ElementTree.fromstring(content[start:].strip())  # noqa: S314 - no entities, see above
    except ElementTree.ParseError as error:
        raise text.refuse(f"the file is not XML: {error}") from None
    value = _element(root, 0)
    return value if isinstance(value, dict) else {root.tag: value}


def _element(element: ElementTree.Element, depth: int) -> object:
    if depth > MAX_XML_DEPTH:
        raise text.refuse("nested too deeply")
    children = list(element)
    attributes = {key: value for key, value in element.attrib.items() if key != "type_id"}
    if not children and not attributes:
        return _plain((element.text or "").strip())
    if children and all(child.tag == "_" for child in children):  # a sequence
        return [_element(child, depth + 1) for child in children]
    members: dict[str, object] = dict(attributes)
    values: dict[str, list[object]] = {}
    for child in children:
        values.setdefault(child.tag.rpartition("}")[2], []).append(_element(child, depth + 1))
    for tag, same in values.items():
        members[tag] = same if len(same) > 1 else same[0]
    return members


def _plain(content: str) -> object:
    if len(content) > 1 and content[0] == content[-1] == '"':
        return content[1:-1]
    numbers = text.number_list(content)
    if numbers is None:
        return content
    return numbers if len(numbers) > 1 else numbers[0]


MAX_LINES = 20_000
_COMMENT = ("#", ";", "//", "%")


def is_ros_ini(content: str) -> bool:
    """True if it is what ROS calls videre INI: sections, a name on a line, its numbers below."""
    heading = re.search(r"^[ \t]*\[image\][ \t]*$", content, re.MULTILINE)
    return bool(heading and re.search(r"^[ \t]*camera matrix", content, re.MULTILINE))


def is_assignments(content: str) -> bool:
    """True if its lines are `name = value`, in sections or not."""
    lines = [
        line
        for line in content.splitlines()[:MAX_LINES]
        if line.strip() and not line.lstrip().startswith(_COMMENT)
    ]
    assigned = sum(bool(re.match(r"\s*[\w.\- ]{1,60}=", line)) for line in lines)
    return assigned > 0 and 2 * assigned >= len(lines)


def ros_ini(content: str) -> list[dict[str, Any]]:
    """Return size, matrix and coefficients of the cameras of such a file."""
    size: dict[str, Any] = {}
    sections: list[dict[str, Any]] = []
    section = key = ""
    for raw in content.splitlines()[:MAX_LINES]:
        line = raw.strip()
        if not line or line.startswith(_COMMENT):
            continue
        if heading := re.fullmatch(r"\[(.{1,80})\]", line):
            section, key = heading[1].strip(), ""
            if section == "image":
                size = {}
            elif section != "externals":
                sections.append({"camera_name": section, "image": size, "numbers": {}})
            continue
        numbers = text.number_list(line)
        if numbers is None:
            key = line.lower()
        elif section == "image" and key in ("width", "height"):
            size[key] = numbers[0]
        elif sections and section == sections[-1]["camera_name"] and key:
            sections[-1]["numbers"].setdefault(key, []).extend(numbers)
    for camera in sections:
        camera.update({**camera.pop("numbers"), **camera.pop("image"), "camera_name": camera["camera_name"]})
        camera.pop("projection", None)  # of the rectified picture
        camera.pop("rectification", None)
    return [camera for camera in sections if "camera matrix" in camera]


def assignments(content: str) -> dict[str, Any]:
    """Return `name = value` lines, by section if there are some: numbers, lists of numbers, texts."""
    values: dict[str, Any] = {}
    here = values
    for raw in content.splitlines()[:MAX_LINES]:
        line = raw.strip()
        if heading := re.fullmatch(r"\[([^\[\]]{1,80})\]", line):
            section = values.setdefault(heading[1].strip(), {})
            here = section if isinstance(section, dict) else {}
            continue
        match = re.match(r"([A-Za-z_][\w.\- ]{0,59}?)\s*=\s*(.*)$", line)
        if not match:
            continue
        value = re.split(r"\s[%#]|;\s*[%#]|\s//", match[2])[0].strip().rstrip(";").strip()
        numbers = text.number_list(value)
        if numbers is None:
            here[match[1]] = value.strip("'\"")
        else:
            here[match[1]] = numbers if len(numbers) > 1 or value[:1] in "[({" else numbers[0]
    return values


def numbers_alone(content: str) -> dict[str, Any] | None:
    """Return the camera of a file of bare numbers, as numpy.savetxt writes it: a matrix, coefficients."""
    lines = [
        line for line in content.splitlines()[:100] if line.strip() and not line.lstrip().startswith(_COMMENT)
    ]
    values: list[float] = []
    for line in lines:
        numbers = text.number_list(line)
        if numbers is None or len(values) > 9 + 14:
            return None
        values += numbers
    is_matrix = len(values) >= 9 and values[1] == values[3] == values[6] == values[7] == 0 and values[8] == 1
    if not is_matrix or len(values) - 9 not in (0, 4, 5, 8, 12, 14):
        return None
    return {"camera_matrix": values[:9], "distortion_coefficients": values[9:]}
