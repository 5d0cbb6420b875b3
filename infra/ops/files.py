"""Parser of untrusted calibration files, with limits on size and depth."""

from __future__ import annotations

import json
from pathlib import Path

import yaml
from yaml.events import AliasEvent
from yaml.nodes import MappingNode, Node

from calibsolver import CalibrationError
from calibsolver.formats import ImportedFile
from calibsolver.formats.reading import read, read_text
from infra.ops.errors import OpsError

_MAX_JSON_BYTES = 64 * 2**20  # bytes; keypoints make files large
_MAX_YAML_BYTES = 2**20  # bytes; a camera alone is a few hundred
_MAX_DEPTH = 20


class _FormError(ValueError):
    """The text is not of the form that it should be."""


def read_file(path: Path, squares: tuple[int, int] | None = None) -> ImportedFile:
    """Read a calibration file: PhotonVision, Gyroflow, OpenCV or calibDB JSON, OpenCV, ROS or Kalibr YAML,
    mrcal's .cameramodel, or a table of corners of a board of so many `squares`.

    Raises OpsError, which says what is wrong with it.
    """  # noqa: D205 - a list of names
    try:
        content = _text(path)
        start = content.lstrip()[:1]
        if path.suffix == ".vnl" or "'lensmodel'" in content or '"lensmodel":  ' in content:
            return read_text(content, squares)
        if path.suffix == ".json" or start in "{[":
            return read(_json(content))
        return read(_yaml(content))
    except (CalibrationError, _FormError) as error:
        raise OpsError(f"{path}: {error}") from error
    except RecursionError:
        raise OpsError(f"{path}: nested too deeply") from None


def _text(path: Path) -> str:
    with path.open("rb") as file:
        raw = file.read(_MAX_JSON_BYTES + 1)
    if len(raw) > _MAX_JSON_BYTES:
        raise OpsError(f"{path} is larger than {_MAX_JSON_BYTES >> 20} MB")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise OpsError(f"{path} is no text") from None


def _json(content: str) -> object:
    def refuse(name: str) -> object:
        raise _FormError(f"the file holds {name}, which is no number")

    try:
        found: object = json.loads(content, parse_constant=refuse)
    except json.JSONDecodeError as error:
        raise _FormError(f"the file is no JSON: {error}") from error
    return found


class _Loader(yaml.SafeLoader):
    """No aliases (a few hundred bytes of them stand for gigabytes), no great depth; OpenCV's matrices."""

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


_Loader.add_constructor("tag:yaml.org,2002:opencv-matrix", _matrix)


def _yaml(content: str) -> object:
    if len(content) > _MAX_YAML_BYTES:
        raise _FormError(f"the file is larger than {_MAX_YAML_BYTES >> 20} MB")
    # OpenCV writes its version with a colon, which no YAML reader takes
    lines = content.splitlines()
    if lines and lines[0].startswith("%YAML:"):
        lines = lines[1:]
    try:
        found: object = yaml.load("\n".join(lines), Loader=_Loader)  # noqa: S506 - a safe loader
    except yaml.YAMLError as error:
        raise _FormError(f"the file is no YAML: {error}") from error
    except (ValueError, OverflowError) as error:  # an impossible date, a number of a million digits
        raise _FormError(f"the file holds a value that cannot be read: {error}") from error
    return found
