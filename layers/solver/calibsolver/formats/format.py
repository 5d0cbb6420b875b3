"""Base of the file formats."""

from abc import ABC, abstractmethod
from dataclasses import replace

from .base import Conversion, ExportSource, ModelConstraint
from .convert import convert, share_behind

MEDIA_TYPES = {
    ".json": "application/json",
    **dict.fromkeys((".yaml", ".yml"), "application/yaml"),
    ".xml": "application/xml",
    ".gltf": "model/gltf+json",
    **dict.fromkeys((".dat", ".opcodelist3"), "application/octet-stream"),
}


class Format(ABC):
    """One tool's file: what it can hold, and its writer."""

    name: str
    suffix: str
    constraints: tuple[ModelConstraint, ...]
    front_readers: str = ""
    """Tools that read the file and project only points in front of the camera, by dividing by z."""

    @property
    def media_type(self) -> str:
        """Media type of a download."""
        return MEDIA_TYPES.get(self.suffix, "text/plain; charset=utf-8")

    def convert(self, source: ExportSource) -> Conversion:
        """Return the closest camera that the file can hold; CalibrationError ``not_representable``."""
        return convert(source, self.constraints)

    def check(self, conversion: Conversion) -> Conversion:
        """Add what the file's tools cannot do with the camera to be written.

        Raises CalibrationError ``not_representable`` if they refuse it.
        """
        behind = share_behind(conversion.camera) if self.front_readers else 0.0
        if not behind:
            return conversion
        return replace(
            conversion,
            remark=f"{self.front_readers} cannot project rays at 90 degrees from the axis or "
            f"beyond, {max(100 * behind, 0.1):.1f} % of the image.",
        )

    @abstractmethod
    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        """Return the file's content; `conversion.camera` is what it says, the rest is `source`'s."""

    def comment(self, source: ExportSource, conversion: Conversion) -> list[str]:
        """Return comments: whose calibration this is, its expected error, and the warning.

        The error is that of the record: of the picture as calibrated, with what is systematic in the views.
        """
        name = " ".join("".join(c if c.isprintable() else " " for c in source.name).split())
        whose = f"# {name} {source.identifier}".rstrip()
        lines = [whose]
        error, size = source.record.get("uncertainty"), source.record.get("img_size")
        if error and size:
            over = f"{size[0]} x {size[1]} px"
            lines.append(
                f"# expected error over {over}: {error['rms']:.3g} px rms, {error['max']:.3g} px at most"
            )
        return [*lines, f"# {conversion.warning}"] if conversion.warning else lines
