"""Output of the command: results on standard output, everything else on standard error."""

import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..files import ExportedFile, write_whole
from ..recording import Progress

LINES_EVERY_S = 5.0
"""Time between two lines of progress without a terminal."""


class Output:
    """Standard output, one JSON document if `json`, and standard error."""

    def __init__(self, json: bool = False) -> None:
        self.json = json

    def problem(self, text: str) -> None:
        """Write an error in one line."""
        print(f"calibdb: {_one_line(text)}", file=sys.stderr)

    def note(self, text: str) -> None:
        """Write something that is not the result."""
        print(_one_line(text), file=sys.stderr)

    def document(self, value: object) -> None:
        """Write the JSON document."""
        print(json.dumps(value, indent=2, ensure_ascii=False))

    def facts(self, rows: Sequence[tuple[str, str]]) -> None:
        """Write names and values."""
        width = max((len(name) for name, _ in rows), default=0)
        for name, value in rows:
            print(f"{name:<{width}}  {_one_line(value)}")

    def table(self, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Write rows in columns: the first and the last flush left, numbers flush right."""
        lines = [[_one_line(cell) for cell in row] for row in (heads, *rows)]
        widths = [max(len(line[n]) for line in lines) for n in range(len(heads))]
        for first, *numbers, last in lines:
            cells = [cell.rjust(width) for cell, width in zip(numbers, widths[1:], strict=False)]
            print("  ".join([first.ljust(widths[0]), *cells, last]).rstrip())

    def file(self, file: ExportedFile, path: str | None) -> None:
        """Write a file to a path, or to standard output."""
        if file.warning:
            self.note(file.warning)
        if path is None or path == "-":
            sys.stdout.flush()
            sys.stdout.buffer.write(file.content)
            sys.stdout.buffer.flush()
            return
        write_whole(Path(path), file.content)
        self.note(f"wrote {path}")


def _one_line(text: str) -> str:
    """Return text without control characters: labels and responses are not trusted."""
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
        rms, most = uncertainty["rms"], uncertainty["max"]
        rows.append(("uncertainty", f"{rms:.2f} px over {_covered(record)}, {most:.2f} px at most"))
        mm = 1000 / (fx * fy) ** 0.5  # of a pixel, at 1 m
        rows.append(("at 1 m", f"{mm * rms:.2f} mm"))
        if (inside := uncertainty.get("inside")) is not None:
            where = f"where the board was, {uncertainty['covered']:.0%} of the image"
            rows.append(("inside", f"{inside:.2f} px, {mm * inside:.2f} mm at 1 m: {where}"))
    if "reliable" in record:
        count = int(record.get("calibrations", 1))
        basis = f"{count} calibrations agree" if count > 1 else "one calibration so far"
        rows.append(("reliable", f"{'yes' if record['reliable'] else 'no'}: {basis}"))
    if record.get("exact_size") is False:
        rows.append(("note", "another size than the one asked for: never rescale it blindly"))
    if record.get("id"):
        rows.append(("id", str(record["id"])))
    return rows


def estimate_facts(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return names and values of an estimate, for people."""
    low, high = record["interval_90"]["hfov_deg"]
    (fx, _, _), _, _ = record["camera_matrix"]
    rows = [
        ("estimate", "not calibrated: this is likely, not measured"),
        ("field of view", f"{record['hfov_deg']:.1f} degrees; 90 %: {low:.1f} to {high:.1f}"),
        ("focal length", f"{fx:.0f} px"),
        ("basis", str(record["basis"])),
    ]
    return rows + [("source", f"{each['title']}, {each['url']}") for each in record.get("sources", ())]


def _covered(record: Mapping[str, Any]) -> str:
    """Return the part of the image for which an uncertainty is stated: that of which the model has rays."""
    import calibsolver

    try:
        share = calibsolver.Camera.from_record(record).domain().covered
    except (calibsolver.CalibrationError, KeyError, TypeError, ValueError):
        return "the image"
    return "the image" if share > 0.9995 else f"the {100 * share:.0f} % of the image that the model covers"


@contextmanager
def progress(what: str) -> Iterator[Progress]:
    """Show how many of how many are done, as long as the block lasts."""
    if not sys.stderr.isatty():
        yield _lines(what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(what, total=None)
        yield lambda done, count: shown.update(task, completed=done, total=count)


def _lines(what: str) -> Progress:
    written = time.monotonic()

    def advance(done: int, count: int) -> None:
        nonlocal written
        if time.monotonic() - written >= LINES_EVERY_S:
            written = time.monotonic()
            print(f"{what}: {done} of {count}", file=sys.stderr, flush=True)

    return advance
