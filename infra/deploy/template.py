"""CloudFormation templates as YAML: short forms such as `!Ref X` become their long forms."""

from pathlib import Path
from typing import Any

import yaml


def parse(path: Path) -> dict[str, Any]:
    """Parse a template."""
    document: dict[str, Any] = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)  # noqa: S506
    return document


class _Loader(yaml.CSafeLoader):
    """libyaml's loader, as the template is read at each start of a stack."""


def _short_form(loader: _Loader, suffix: str, node: Any) -> dict[str, Any]:
    value: Any
    if isinstance(node, yaml.MappingNode):
        value = loader.construct_mapping(node, deep=True)
    elif isinstance(node, yaml.SequenceNode):
        value = loader.construct_sequence(node, deep=True)
    else:
        value = loader.construct_scalar(node)
    if suffix == "GetAtt" and isinstance(value, str):
        value = value.split(".", 1)
    return {suffix if suffix in ("Ref", "Condition") else f"Fn::{suffix}": value}


_Loader.add_multi_constructor("!", _short_form)
