"""Untrusted calibration files: bytes to plain values, with limits on size and depth."""

from __future__ import annotations

import codecs
import json
import re

import yaml
from yaml.events import AliasEvent
from yaml.nodes import MappingNode, Node, SequenceNode

from ..errors import CalibrationError
from .text import refuse

_MAX_YAML_BYTES = 2**20  # bytes; one camera is a few hundred
_MAX_DEPTH = 20
_MIN_ASCII = 0.9  # share of a file in an unknown eight-bit encoding that is plain ASCII
_BINARY = {
    b"\x1f\x8b": "a gzip archive: unpack it, and give the calibration file in it (of ROS: ost.yaml)",
    b"\x80": "a Python pickle, which may run code and is not read: save .npz, JSON or YAML instead",
    b"\x93NUMPY": "one numpy array: save the camera matrix and the coefficients together as .npz",
    b"MATLAB 5.0": "a MATLAB file: export the camera as JSON, or as a text of fc, cc and kc",
    b"\x89HDF": "an HDF5 file: export the camera as JSON or YAML",
    b"\x89PNG": "a picture, no text",
    b"\xff\xd8": "a picture, no text",
}
"""First bytes of files that hold no text, and the remedy for each."""


def decode(raw: bytes) -> str:
    """Decode UTF-8, UTF-16 (with its mark, or mostly ASCII), or eight bits, ASCII but for remarks."""
    for start, what in _BINARY.items():
        if raw.startswith(start):
            raise refuse(f"it is no text but {what}" if "no text" not in what else f"it is {what}")
    if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encodings = ["utf-16"]
    elif b"\0" in raw[:200]:
        encodings = ["utf-16-le" if raw[1:2] == b"\0" else "utf-16-be"]
    else:
        encodings = ["utf-8-sig"]
        if sum(byte < 0x80 for byte in raw[:100_000]) >= _MIN_ASCII * len(raw[:100_000]):
            encodings.append("cp1252")
    for encoding in encodings:
        try:
            content = raw.decode(encoding)
        except UnicodeDecodeError:
            continue
        return re.sub(r"\r\n?", "\n", content.lstrip("\ufeff").rstrip("\0"))
    raise refuse("it is not text: neither UTF-8 nor UTF-16")


def parse_json(content: str, suffix: str) -> object:
    """Parse JSON; None if it may be YAML or a Python dictionary."""
    try:
        value: object = json.loads(content)
    except json.JSONDecodeError as error:
        if suffix == ".json":
            if len(content) <= _MAX_YAML_BYTES:
                try:  # a comma too many, comments
                    return parse_yaml(re.sub(r"^[ \t]*//.*$", "", content, flags=re.MULTILINE))
                except CalibrationError:
                    pass
            raise refuse(f"the file is not JSON: {error}") from error
        return None
    except ValueError as error:  # a number of a million digits
        raise refuse(f"the file holds a value that cannot be read: {error}") from error
    return value


class _Loader(yaml.SafeLoader):
    """Without aliases (a few hundred bytes of them stand for gigabytes) and great depth."""

    depth = 0

    def compose_node(self, parent: Node | None, index: int) -> Node | None:
        if self.check_event(AliasEvent):
            raise yaml.MarkedYAMLError("aliases are not allowed")
        self.depth += 1
        if self.depth > _MAX_DEPTH:
            raise yaml.MarkedYAMLError("nested too deeply")
        try:
            node: Node | None = super().compose_node(parent, index)
        finally:
            self.depth -= 1
        return node


def _matrix(loader: yaml.SafeLoader, node: Node) -> object:
    if not isinstance(node, MappingNode):
        raise yaml.MarkedYAMLError("a matrix must be a mapping", problem_mark=node.start_mark)
    return loader.construct_mapping(node, deep=True)


def _tuple(loader: yaml.SafeLoader, node: Node) -> object:
    if not isinstance(node, SequenceNode):
        raise yaml.MarkedYAMLError("a tuple must be a list", problem_mark=node.start_mark)
    return loader.construct_sequence(node, deep=True)


for _tag in ("opencv-matrix", "opencv-nd-matrix"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_tag}", _matrix)
    _Loader.add_constructor(f"!{_tag}", _matrix)
_Loader.add_constructor("tag:yaml.org,2002:python/tuple", _tuple)


def parse_yaml(content: str) -> object:
    """Parse the first document that holds something."""
    if len(content) > _MAX_YAML_BYTES:
        raise refuse(f"the file is larger than {_MAX_YAML_BYTES >> 20} MB")
    if "python/object" in content and "numpy" in content:
        raise refuse(
            "the file is not YAML of plain values: it contains numpy objects, which may run code and are not "
            "read; write lists (array.tolist())"
        )
    try:
        for document in yaml.load_all(_plain_yaml(content), Loader=_Loader):
            if document is not None:
                value: object = document
                return value
    except yaml.YAMLError as error:
        raise refuse(f"the file is not YAML: {_one_line(error)}") from error
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        # An impossible date, a number of a million digits, an empty `!!float`.
        raise refuse(f"the file holds a value that cannot be read: {error}") from error
    raise refuse("the file is empty")


def _plain_yaml(content: str) -> str:
    """Write OpenCV's dialect as YAML: a version with a colon, tabs as indent, names without a space after."""
    plain = "\n".join(line for line in content.expandtabs(4).split("\n") if not line.startswith("%"))
    return re.sub(r"^([ \t]*(?:- )?[A-Za-z_][\w.]*):(?=[-+.\d\[\"!])", r"\1: ", plain, flags=re.MULTILINE)


def _one_line(error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    what = getattr(error, "problem", None) or getattr(error, "context", None) or str(error).split("\n", 1)[0]
    return f"{what}, in line {mark.line + 1}" if mark else str(what)
