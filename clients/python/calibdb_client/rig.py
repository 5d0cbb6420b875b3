"""A rig as the service returns it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from calibsolver import rotation
from calibsolver.arrays import Array

from .calibration import Calibration, Exporter
from .errors import UsageError
from .files import ExportedFile, read_object, write_whole

_JSON = "json"


@dataclass(frozen=True, eq=False)
class Rig:
    """Two to eight cameras that do not move against each other.

    `record` is all that the service answered (docs/api.md). Raises UsageError for a record that is not a rig.
    """

    record: Mapping[str, Any]
    _exporter: Exporter | None = field(default=None, repr=False)
    _camera_exporter: Exporter | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        try:
            poses = [np.array([*each["rvec"], *each["tvec"]], dtype=np.float64) for each in self._extrinsics]
            whole = len(self.record["calibrations"]) == len(poses) >= 2
            whole = whole and all(pose.shape == (6,) and bool(np.isfinite(pose).all()) for pose in poses)
            whole = whole and isinstance(self.record["unit"], str)
        except (KeyError, TypeError, ValueError):
            whole = False
        if not whole:
            raise UsageError("not a rig: calibrations and extrinsics of two or more cameras are required")

    def __repr__(self) -> str:
        return f"Rig({self.id!r}, {len(self.calibrations)} cameras, {self.unit}, {self.verdict[0]})"

    @classmethod
    def load(cls, path: str | Path) -> Rig:
        """Read a JSON file that `save` wrote. Raises UsageError for any other file."""
        record = read_object(Path(path))
        if record is None:
            raise UsageError(f"{path} is not a rig")
        return cls(record)

    @cached_property
    def calibrations(self) -> tuple[Calibration, ...]:
        """Cameras as they were fitted together, by position."""
        return tuple(Calibration(record, self._camera_exporter) for record in self.record["calibrations"])

    @property
    def id(self) -> str | None:
        """Id at the service."""
        return self.record.get("rig_id")

    @property
    def unit(self) -> str:
        """Unit of translations: ``metres``, or ``squares`` of the board if they were not measured."""
        return str(self.record["unit"])

    @property
    def uncertainty(self) -> dict[str, float]:
        """Predicted error, as `rotation_deg`, `translation_percent` and `rms` px of one camera in another."""
        return dict(self.record.get("uncertainty") or {})

    @property
    def rms(self) -> float:
        """px, over all points of the capture."""
        return float(self.record["rms"])

    @property
    def verdict(self) -> tuple[str, ...]:
        """Level, ``good``, ``fair`` or ``poor``, then reasons: ``uncertain``, ``held_out``, ``set_aside``."""
        verdict = self.record.get("verdict") or {}
        return str(verdict.get("level", "")), *map(str, verdict.get("reasons", ()))

    def pose(self, position: int, origin: int = 0) -> Array:
        """Return the motion (4, 4), x -> R x + t, from the camera at `origin` to the one at `position`.

        Both frames are x right, y down, z forward. Raises UsageError for a position that the rig lacks.
        """
        there: Array = self._from_first(position) @ np.linalg.inv(self._from_first(origin))
        return there

    def std(self, position: int) -> Array:
        """Return the standard deviations (6,) of rvec, radians, and tvec of `pose(position)`."""
        return np.array(self._of(position).get("std", [np.nan] * 6), dtype=np.float64)

    def to_metres(self, square_size: float) -> Rig:
        """Return this rig in metres; one in squares needs the side of a square, metres."""
        if self.unit == "metres":
            return self
        if not square_size > 0:
            raise UsageError(f"the side of a square is above 0 metres, not {square_size}")
        extrinsics = []
        for each in self._extrinsics:
            std = self.std(each["position"])
            std[3:] *= square_size
            tvec = [value * square_size for value in each["tvec"]]
            extrinsics.append({**each, "tvec": tvec, "std": std.tolist()})
        boards = [
            {**each, "tvec": [value * square_size for value in each["tvec"]]}
            for each in self.record.get("board_poses", ())
        ]
        record = {**self.record, "extrinsics": extrinsics, "board_poses": boards, "unit": "metres"}
        return replace(self, record=record, _exporter=None)

    def save(self, path: str | Path, format: str | None = None) -> ExportedFile:  # noqa: A002 - the contract's name
        """Write a file of one of the formats of docs/formats.md, as a whole or not at all, and return it.

        Without a format the suffix of the path says it; one that contradicts the suffix raises UsageError.
        """
        from . import conversion

        file = self.export(conversion.format_of(format, path, rig=True))
        write_whole(Path(path), file.content)
        return file

    def export(self, format: str = _JSON) -> ExportedFile:  # noqa: A002
        """Return the file in one of the formats of docs/formats.md; several files are one ZIP archive.

        The service writes its own rigs, calibsolver all others. Raises UsageError if the format cannot hold
        the rig.
        """
        if format == _JSON:
            content = json.dumps(dict(self.record), indent=2, ensure_ascii=False) + "\n"
            return ExportedFile(content.encode(), "rig.json", "application/json")
        if self.id and self._exporter:
            return self._exporter(self.id, format)
        from . import conversion

        return conversion.write_rig(self.record, format)

    @property
    def _extrinsics(self) -> list[Mapping[str, Any]]:
        return list(self.record["extrinsics"])

    def _of(self, position: int) -> Mapping[str, Any]:
        matches = [each for each in self._extrinsics if each.get("position") == position]
        if not matches:
            raise UsageError(
                f"this rig has cameras 0 to {len(self.calibrations) - 1}, and no camera {position}"
            )
        return matches[0]

    def _from_first(self, position: int) -> Array:
        extrinsics = self._of(position)
        motion = np.eye(4)
        motion[:3, :3] = rotation.matrix(np.array(extrinsics["rvec"], dtype=np.float64))
        motion[:3, 3] = extrinsics["tvec"]
        return motion


def is_rig(path: Path) -> bool:
    """Return True if a file is a rig that `Rig.save` wrote."""
    return "extrinsics" in (read_object(path) or {})
