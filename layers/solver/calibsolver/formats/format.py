"""Base of every file format: capabilities and writer."""

from abc import ABC, abstractmethod

from .base import Conversion, Shape, Subject
from .convert import convert


class Format(ABC):
    """One tool's file."""

    name: str
    suffix: str
    media_type: str = "text/plain; charset=utf-8"
    shapes: tuple[Shape, ...]

    def convert(self, subject: Subject) -> Conversion:
        """Return the closest camera that the file can hold; CalibrationError ``not_representable``."""
        return convert(subject, self.shapes)

    @abstractmethod
    def write(self, subject: Subject, held: Conversion) -> bytes:
        """Return the file's content; `held.camera` is what it says, the rest is `subject`'s."""

    def comment(self, subject: Subject, held: Conversion) -> list[str]:
        """Say whose calibration this is, and the warning, where comments begin with a hash."""
        name = " ".join("".join(c if c.isprintable() else " " for c in subject.name).split())
        whose = f"# {name} {subject.identifier}".rstrip()
        return [whose, f"# {held.warning}"] if held.warning else [whose]
