"""XML read as plain values: OpenCV's FileStorage, and other tools' elements and attributes."""

import re
import xml.etree.ElementTree as ElementTree

from . import text

MAX_XML_DEPTH = 20
EXTERNAL_TYPE = re.compile(r"<!DOCTYPE\s+\w+\s+SYSTEM\s+(?:\"[^\"<>]{0,200}\"|'[^'<>]{0,200}')\s*>")
"""Document type in another file, without entities of its own."""


def parse(content: str) -> object:
    """Return the values below the root: mappings, lists, numbers, strings.

    Raises CalibrationError ``malformed`` if it is not XML, or declares entities: those of a few
    hundred bytes can stand for gigabytes, or for other files.
    """
    start = content.find("?>") + 2 if content.lstrip().startswith("<?xml") else 0
    content = EXTERNAL_TYPE.sub("", content, count=1)  # nothing reads the file that it names
    if "<!DOCTYPE" in content or "<!ENTITY" in content:
        raise text.refuse("the XML declares entities, which calibration files do not need")
    try:
        root = ElementTree.fromstring(content[start:].strip())  # noqa: S314 - no entities, see above
    except ElementTree.ParseError as error:
        raise text.refuse(f"the file is not XML: {error}") from None
    value = _value(root, 0)
    return value if isinstance(value, dict) else {root.tag: value}


def _value(element: ElementTree.Element, depth: int) -> object:
    if depth > MAX_XML_DEPTH:
        raise text.refuse("nested too deeply")
    children = list(element)
    attributes = {key: value for key, value in element.attrib.items() if key != "type_id"}
    if not children and not attributes:
        return _plain((element.text or "").strip())
    if children and all(child.tag == "_" for child in children):  # a sequence
        return [_value(child, depth + 1) for child in children]
    members: dict[str, object] = dict(attributes)
    values: dict[str, list[object]] = {}
    for child in children:
        values.setdefault(child.tag.rpartition("}")[2], []).append(_value(child, depth + 1))
    for tag, same in values.items():
        members[tag] = same if len(same) > 1 else same[0]
    return members


def _plain(content: str) -> object:
    """Return a string that stood in quotes, numbers, or a text."""
    if len(content) > 1 and content[0] == content[-1] == '"':
        return content[1:-1]
    numbers = text.number_list(content)
    if numbers is None:
        return content
    return numbers if len(numbers) > 1 else numbers[0]
