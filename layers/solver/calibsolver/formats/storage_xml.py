"""XML read as plain values: OpenCV's FileStorage, and other tools' elements and attributes."""

import xml.etree.ElementTree as ElementTree
from collections import Counter

from . import text

MAX_XML_DEPTH = 20


def parse(content: str) -> object:
    """Return the values below the root: mappings, lists, numbers, strings.

    Raises CalibrationError ``malformed`` for what is no XML, or declares a document type: entities of a few
    hundred bytes can stand for gigabytes, or for other files.
    """
    if "<!DOCTYPE" in content or "<!ENTITY" in content:
        raise text.refuse("the XML declares a document type, which calibration files do not need")
    start = content.find("?>") + 2 if content.lstrip().startswith("<?xml") else 0
    try:
        root = ElementTree.fromstring(content[start:].strip())  # noqa: S314 - no entities, see above
    except ElementTree.ParseError as error:
        raise text.refuse(f"the file is no XML: {error}") from None
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
    found: dict[str, object] = dict(attributes)
    for child in children:
        tag, value = child.tag.rpartition("}")[2], _value(child, depth + 1)
        if tag in found and isinstance(found[tag], list) and tag in repeated_names(element):
            found[tag].append(value)  # type: ignore[attr-defined]
        elif tag in repeated_names(element):
            found[tag] = [value]
        else:
            found[tag] = value
    return found


def repeated_names(element: ElementTree.Element) -> set[str]:
    """Return the names that several children have."""
    counts = Counter(child.tag.rpartition("}")[2] for child in element)
    return {tag for tag, count in counts.items() if count > 1}


def _plain(content: str) -> object:
    """Return a string that stood in quotes, numbers, or a text."""
    if len(content) > 1 and content[0] == content[-1] == '"':
        return content[1:-1]
    numbers = text.number_list(content)
    if numbers is None:
        return content
    return numbers if len(numbers) > 1 else numbers[0]
