"""Report of a calibration with its corners."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import CaptureError, MissingPackageError, UsageError

if TYPE_CHECKING:
    from calibsolver import Calibration as Fit
    from calibsolver import View

    from .calibration import Calibration
    from .recording import Recording

REPORT_SUFFIXES = (".html", ".png", ".pdf")
_STYLE = (
    "body{font:15px/1.45 system-ui,sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;color:#222}"
    "img{max-width:100%}table{border-collapse:collapse}td,th{padding:.15em .8em;text-align:right}"
    "td:first-child,th:first-child,td:last-child,th:last-child{text-align:left}"
    "tr:nth-child(even){background:#f4f6f8}"
)


def rows_of(
    recording: Recording, fit: Fit, left_out: Iterable[tuple[str, str]] = ()
) -> list[tuple[str, ...]]:
    """Return a row of each picture of a recording, under a fit of its views.

    Name, corners, those that took part in the fit, px rms of these (nan if none did), and why it is left out.
    """
    from .session import refusal

    rows: list[tuple[str, ...]] = []
    known = dict(left_out)
    lengths = [np.linalg.norm(vectors, axis=1) for vectors in fit.residuals]
    for n, (view, length, used) in enumerate(zip(recording.views, lengths, fit.used, strict=True)):
        counted = length[used]
        rms = float(np.sqrt(np.mean(counted**2))) if len(counted) else float("nan")
        why = known.get(view.source, refusal(fit.cut_views[n]) if n in fit.cut_views else "")
        rows.append((view.source, str(len(view.ids)), str(used.sum()), f"{rms:.3f}", why))
    return rows


def write_report(
    path: str | Path, calibration: Calibration, picture: Any = None, square_mm: float | None = None
) -> None:
    """Write a report of a calibration that has its corners; the suffix says whether HTML, PNG or PDF.

    It is fitted to its corners again, for poses and error bars. `picture` (h, w) or (h, w, 3), one of its
    pictures, is shown before and after. `square_mm`: side of a square, or of a tag.

    Raises UsageError for another suffix, or if the corners are not there; MissingPackageError without
    matplotlib.
    """
    target = Path(path)
    if target.suffix.lower() not in REPORT_SUFFIXES:
        raise UsageError(f"a report is written as {', '.join(REPORT_SUFFIXES)}, not {target.name}")
    recording = calibration.recording
    if recording is None:
        raise UsageError("a report needs the corners: give a file that `calibdb calibrate` wrote")
    try:
        import matplotlib  # noqa: F401

        from calibsolver import plots
    except ImportError:
        raise MissingPackageError("plots need matplotlib: pip install matplotlib") from None
    fit, views = fit_again(recording, calibration)
    w, h = calibration.img_size
    title = f"{recording.key.camera}, {w} x {h}, {fit.camera.model}"
    figure = plots.report(fit, views, title, picture)
    content = io.BytesIO()
    if target.suffix.lower() == ".html":
        figure.savefig(content, format="png", dpi=110)
        figures = fit.board_shape.figures() if fit.board_shape else None
        sentence = recording.board.shape_sentence(figures, square_mm)
        page = _page(title, calibration, fit, rows_of(recording, fit), content.getvalue(), sentence)
        content = io.BytesIO(page.encode())
    else:
        figure.savefig(content, format=target.suffix[1:].lower(), dpi=110)
    from .files import write_whole

    write_whole(target, content.getvalue())


def fit_again(recording: Recording, calibration: Calibration) -> tuple[Fit, list[View]]:
    """Fit a calibration to its corners again, and return the views with it.

    Raises CaptureError if they determine none.
    """
    import calibsolver
    from calibsolver.board import CIRCLES
    from calibsolver.quality.rivals import with_rivals

    try:
        views = recording.observations()
        lens = calibration.lens
        bends = recording.board.kind not in CIRCLES
        fixed = calibration.record.get("fixed", ())
        fit = calibsolver.fit(views, lens.img_size, lens.model, start=lens, fix=fixed, board_shape=bends)
        return with_rivals(fit, views), views
    except (calibsolver.CalibrationError, ValueError) as error:
        raise CaptureError(f"the corners determine no calibration: {error}") from None


def _page(
    title: str,
    calibration: Calibration,
    fit: Fit,
    rows: Sequence[tuple[str, ...]],
    png: bytes,
    board: str | None,
) -> str:
    """Return the page: everything is in it, nothing is loaded from elsewhere."""
    from calibsolver import models

    from .cli.output import calibration_facts

    names = ("fx", "fy", "cx", "cy", *models.get(fit.camera.model).coefficients)
    deviations = np.sqrt(np.diagonal(fit.covariance))
    values = [
        _row(name, f"{value:.6g}", f"± {sigma:.2g}")
        for name, value, sigma in zip(names, fit.camera.intrinsics, deviations, strict=True)
    ]
    pictures = [_row(*row) for row in rows]
    facts = "".join(_row(*fact) for fact in calibration_facts(calibration.record))
    image = base64.b64encode(png).decode()
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{_STYLE}</style><h1>{html.escape(title)}</h1><table>{facts}</table>"
        f"{f'<p>{board}</p>' if board else ''}"
        f'<p><img alt="Residuals, corners, uncertainty, poses, before and after" '
        f'src="data:image/png;base64,{image}"></p>'
        f"<h2>Parameters</h2><table><tr><th></th><th>value</th><th>standard deviation</th></tr>"
        f"{''.join(values)}</table>"
        f"<h2>Pictures</h2><table><tr><th>picture</th><th>corners</th><th>used</th><th>rms, px</th>"
        f"<th></th></tr>{''.join(pictures)}</table></html>\n"
    )


def _row(*cells: str) -> str:
    """Return a row of a table."""
    return "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>"
