"""Base of every file format: capabilities and writer."""

from abc import ABC, abstractmethod

from .base import Conversion, ExportSource, ModelConstraint
from .convert import convert


class Format(ABC):
    """One tool's file."""

    name: str
    suffix: str
    media_type: str = "text/plain; charset=utf-8"
    constraints: tuple[ModelConstraint, ...]

    def convert(self, source: ExportSource) -> Conversion:
        """Return the closest camera that the file can hold; CalibrationError ``not_representable``."""
        return convert(source, self.constraints)

    @abstractmethod
    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        """Return the file's content; `conversion.camera` is what it says, the rest is `source`'s."""

    def comment(self, source: ExportSource, conversion: Conversion) -> list[str]:
        """Say whose calibration this is, and the warning, where comments begin with a hash."""
        name = " ".join("".join(c if c.isprintable() else " " for c in source.name).split())
        whose = f"# {name} {source.identifier}".rstrip()
        return [whose, f"# {conversion.warning}"] if conversion.warning else [whose]
