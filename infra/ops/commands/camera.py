"""Commands that show cameras."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from infra.ops.options import Json
from infra.ops.session import Run, open_run

if TYPE_CHECKING:
    from infra.ops.cameras import CameraDetail

app = typer.Typer(help="List cameras, and show one.", no_args_is_help=True)
_COLUMNS = ("id", "time (UTC)", "contributor", "model", "#views", "#fx (px)", "#rms (px)", "withdrawn")


@app.command("list")
def list_cameras(
    text: Annotated[str, typer.Argument(help="Only those whose key contains this text.")] = "",
    as_json: Json = False,
) -> None:
    """List the cameras that were calibrated."""
    with open_run(as_json=as_json) as run:
        from infra.ops import cameras

        counts = cameras.count_all(run.context, text)
        run.output.table(
            ("camera", "#calibrations", "#withdrawn"),
            ((one.key, one.calibrations, one.withdrawn) for one in counts),
            (one.line for one in counts),
        )
        run.output.value(
            [{"key": one.key, "calibrations": one.calibrations, "withdrawn": one.withdrawn} for one in counts]
        )


@app.command("show")
def show_camera(
    key: Annotated[str, typer.Argument(help="As `camera list` prints it.")],
    plot: Annotated[
        bool, typer.Option("--plot", help="Draw the members of each consensus and the other groups.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Show consensuses and calibrations of one camera."""
    with open_run(as_json=as_json) as run:
        from infra.ops import cameras

        detail = cameras.detail(run.context, key)
        run.output.value(detail.record())
        for text, rows, lines in _sections(detail):
            run.output.line(text)
            if lines:
                run.output.table(_COLUMNS, rows, lines)
        if plot:
            _draw(run, detail)


@app.command("use")
def show_use(
    logs: Annotated[Path, typer.Argument(help="Folder with a copy of the bucket EdgeLogBucket.")],
    as_json: Json = False,
) -> None:
    """Count lookups at the edge by camera."""
    with open_run(as_json=as_json) as run:
        from infra.ops import cameras

        use = cameras.count_use(logs, run.context.store.aliases).most_common()
        run.output.table(("camera", "#lookups"), use, (f"{count:>9}  {label}" for label, count in use))
        run.output.value([{"camera": label, "lookups": count} for label, count in use])


def _sections(detail: CameraDetail) -> Iterator[tuple[str, list[tuple[object, ...]], list[str]]]:
    """Yield lines, and after the consensuses of each mode the rows and the lines of its calibrations."""
    from infra.ops import cameras

    yield f"{detail.camera}, {detail.platform}", [], []
    for mode in detail.modes:
        texts = [
            cameras.title(mode.mode),
            *(f"  {cameras.describe_consensus(c)}" for c in mode.consensuses),
        ]
        rows = [cameras.calibration_row(*one) for one in mode.calibrations]
        lines = [f"  {cameras.describe_calibration(*one)}" for one in mode.calibrations]
        yield "\n".join(texts), rows, lines


def _draw(run: Run, detail: CameraDetail) -> None:
    from infra.ops import plots

    width = min(100, shutil.get_terminal_size().columns)
    for mode in detail.modes:
        if plots.points_by_group(run.context, mode):
            run.output.line(plots.draw(run.context, mode, width))
