"""One tool's file format: what it can hold, and its writer."""

from abc import ABC, abstractmethod
from dataclasses import replace

from .base import Conversion, ExportSource, ModelConstraint
from .convert import convert, share_behind


class Format(ABC):
    """One tool's file."""

    name: str
    suffix: str
    media_type: str = "text/plain; charset=utf-8"
    constraints: tuple[ModelConstraint, ...]
    front_readers: str = ""
    """Tools that read the file and project only points in front of the camera, by dividing by z."""

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
        """Say whose calibration this is, its expected error, and the warning; comments begin with a hash.

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
