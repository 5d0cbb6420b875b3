"""Output of the command: results on standard output, everything else on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..answer import ExportedFile
from ..files import write_whole


class Output:
    """Standard output and standard error.

    Parameters
    ----------
    json
        Whether standard output takes one JSON document and nothing else.
    """

    def __init__(self, json: bool = False) -> None:
        self.json = json

    def problem(self, text: str) -> None:
        """Write an error in one line."""
        print(f"calibdb: {one_line(text)}", file=sys.stderr)

    def note(self, text: str) -> None:
        """Write something that is not the result."""
        print(one_line(text), file=sys.stderr)

    def document(self, value: object) -> None:
        """Write the JSON document."""
        print(json.dumps(value, indent=2, ensure_ascii=False))

    def facts(self, rows: Sequence[tuple[str, str]]) -> None:
        """Write names and values."""
        width = max((len(name) for name, _ in rows), default=0)
        for name, value in rows:
            print(f"{name:<{width}}  {one_line(value)}")

    def file(self, file: ExportedFile, path: str | None) -> None:
        """Write a file where it is wanted: to a path, or to standard output."""
        if file.warning:
            self.note(file.warning)
        if path is None or path == "-":
            sys.stdout.flush()
            sys.stdout.buffer.write(file.content)
            sys.stdout.buffer.flush()
            return
        write_whole(Path(path), file.content)
        self.note(f"wrote {path}")


def one_line(text: str) -> str:
    """Return text without control characters: labels and answers are other people's."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def calibration_facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return names and values of a calibration, for people."""
    (fx, _, cx), (_, fy, cy), _ = record["camera_matrix"]
    w, h = record["img_size"]
    rows = [
        ("camera", str(record.get("camera", ""))),
        ("size", f"{w} x {h}"),
        ("focal lengths", f"{fx:.2f}, {fy:.2f} px"),
        ("centre", f"{cx:.2f}, {cy:.2f} px"),
        ("model", str(record["distortion_model"])),
        ("coefficients", ", ".join(f"{each:.6g}" for each in record["distortion_coefficients"])),
    ]
    if "avg_reprojection_error" in record:
        rows.append(("rms", f"{record['avg_reprojection_error']:.3f} px"))
    if uncertainty := record.get("uncertainty"):
        rows.append(
            (
                "uncertainty",
                f"{uncertainty['rms']:.2f} px over the image, {uncertainty['max']:.2f} px at most",
            )
        )
    if "reliable" in record:
        basis = f"{record.get('calibrations', 1)} calibrations agree"
        rows.append(("reliable", f"{'yes' if record['reliable'] else 'no'}: {basis}"))
    if record.get("exact_size") is False:
        rows.append(("note", "another size than the one asked for: never rescale it blindly"))
    if record.get("id"):
        rows.append(("id", str(record["id"])))
    return rows
