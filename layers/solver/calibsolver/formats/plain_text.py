"""Text files that are neither JSON nor YAML nor XML: ROS's .ini and ost.txt, `name = value`, numbers."""

import re
from typing import Any

from . import text

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
    """Return the cameras of such a file: of each the size, matrix and coefficients."""
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
