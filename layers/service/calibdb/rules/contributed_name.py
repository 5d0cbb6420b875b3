"""Name of a camera: the one that most of its contributors sent."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from calibdb.camera_key import public_label, public_platform
from calibdb.schema import CalibrationDocument


def most_contributed_label(group: Sequence[CalibrationDocument]) -> str:
    """Return the label that most contributors of a group sent, by today's rules; of equals the oldest."""
    return _most_contributed(group, lambda document: public_label(document.camera))


def most_contributed_platform(group: Sequence[CalibrationDocument]) -> str:
    """Return the platform that most contributors of a group sent, by today's rules; of equals the oldest."""
    return _most_contributed(group, lambda document: public_platform(document.platform))


def _most_contributed(
    group: Sequence[CalibrationDocument], public: Callable[[CalibrationDocument], str]
) -> str:
    contributors: dict[str, set[str]] = {}
    for document in sorted(group, key=lambda d: (d.time, d.id)):
        contributors.setdefault(public(document), set()).add(document.counted_as)
    return max(contributors, key=lambda text: len(contributors[text]))  # the first of equals
