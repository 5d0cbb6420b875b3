"""Dump of the database (CC0): JSON Lines that `load` reads, and Parquet tables for analysis."""

import functools
import secrets
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet
from pydantic import BaseModel

from calibdb.dump.public_copy import Alias, aliases, public_copy, unnamed_copy
from calibdb.schema import CalibrationDocument, RigCalibrationDocument
from infra.console import track
from infra.ops import OpsError
from infra.ops.context import OpsContext
from infra.ops.restore import CALIBRATIONS, RIGS, VOTES

Select = Callable[[Any], Any]  # of a stored document, its copy in the dump; None: it stays out
_ROWS = 500  # calibrations written to Parquet together

ABOUT = """calibDB: calibrations of cameras, and the keypoints that they were computed from

To the extent possible under law, everyone who contributed to this dump has waived all copyright and related
rights to it: CC0 1.0 Universal, https://creativecommons.org/publicdomain/zero/1.0/

Each calibration and each vote says under which licence it was given, and the date of the text that its
contributor agreed to. Measurements that were given without a licence are not in here.
"""

PRIVATE = """calibDB: calibrations of cameras, and the keypoints that they were computed from

NOT TO BE GIVEN AWAY: this copy also holds measurements that their contributors gave without a licence. It is
for the operator, to load it into another stack. rigs.jsonl has one finished rig a line.
"""

CONTENTS = """
calibrations.jsonl    one calibration a line, with the corners of every view; pixel centres at whole numbers
votes.jsonl           one check of a camera's calibrations on fresh views a line
calibrations.parquet  one row a calibration: camera, matrix, distortion, error
keypoints.parquet     one row a corner: calibration, view, id on the board, x, y (px)

`contributor` only distinguishes contributors of this dump: other dumps name them otherwise; and so
does `source`, where they were, by which they are counted.
"""

_TABLE = pa.schema(
    [
        *((name, pa.string()) for name in ("id", "camera_key", "camera", "platform")),
        *((name, pa.int32()) for name in ("width", "height")),
        ("zoom", pa.float64()),
        ("distortion_model", pa.string()),
        *((name, pa.float64()) for name in ("fx", "fy", "cx", "cy")),
        ("distortion_coefficients", pa.list_(pa.float64())),
        *((name, pa.float64()) for name in ("avg_reprojection_error", "uncertainty_rms")),
        ("views", pa.int32()),
        ("board_kind", pa.string()),
        *((name, pa.int32()) for name in ("squares_x", "squares_y")),
        ("time", pa.timestamp("s", tz="UTC")),
        *((name, pa.string()) for name in ("contributor", "licence")),
    ]
)
_CORNERS = pa.schema(
    [
        ("calibration", pa.string()),
        ("view", pa.int32()),
        ("corner", pa.int32()),
        ("x", pa.float64()),
        ("y", pa.float64()),
    ]
)


def dump(context: OpsContext, folder: Path, *, private: bool = False) -> tuple[int, int]:
    """Write all that may be given away to a new folder; return the numbers of calibrations and votes.

    Withdrawn calibrations are left out, and, unless `private` (for the operator only), what was given without
    a licence. Contributors are named by a hash whose key is thrown away.

    Raises OpsError if the folder exists.
    """
    if folder.exists():
        raise OpsError(f"{folder} is there already; a dump needs a folder of its own")
    alias = aliases(secrets.token_hex(32))
    select = functools.partial(unnamed_copy if private else public_copy, alias=alias)
    draft = folder.with_name(folder.name + ".partial")  # a dump is whole or it is not there
    draft.mkdir(parents=True, exist_ok=True)
    with (
        (draft / CALIBRATIONS).open("w", encoding="utf-8") as lines,
        parquet.ParquetWriter(draft / "calibrations.parquet", _TABLE, compression="zstd") as table,
        parquet.ParquetWriter(draft / "keypoints.parquet", _CORNERS, compression="zstd") as corners,
    ):
        count = 0
        batch: list[CalibrationDocument] = []
        for stored, withdrawn in context.every_calibration():
            document = None if withdrawn else select(stored)
            if document is None:
                continue
            lines.write(document.model_dump_json() + "\n")
            count += 1
            batch.append(document)
            if len(batch) == _ROWS:
                _write(table, corners, batch)
                batch = []
        _write(table, corners, batch)
    votes = _write_lines(draft / VOTES, map(select, track(context.store.votes.all(), "votes")))
    if private:
        rigs = track(context.store.rigs.calibrations(), "rigs")
        _write_lines(draft / RIGS, (_renamed(rig, alias) for rig in rigs))
    (draft / "README.txt").write_text((PRIVATE if private else ABOUT) + CONTENTS, encoding="utf-8")
    draft.rename(folder)
    return count, votes


def _renamed(rig: RigCalibrationDocument, alias: Alias) -> RigCalibrationDocument:
    return rig.model_copy(update={"contributors": tuple(alias(one) for one in rig.contributors)})


def _write_lines(path: Path, copies: Iterable[BaseModel | None]) -> int:
    count = 0
    with path.open("w", encoding="utf-8") as lines:
        for copy in copies:
            if copy is not None:
                lines.write(copy.model_dump_json() + "\n")
                count += 1
    return count


def _write(table: Any, corners: Any, documents: list[CalibrationDocument]) -> None:
    if documents:
        table.write_table(pa.Table.from_pylist([document_row(d) for d in documents], _TABLE))
        corners.write_table(pa.Table.from_pylist([row for d in documents for row in _points(d)], _CORNERS))


def document_row(document: CalibrationDocument) -> dict[str, Any]:
    """Return the row of a calibration in the table of all."""
    fit = document.fits[document.distortion_model]
    (fx, _, cx), (_, fy, cy), _ = fit.camera_matrix
    return document.model_dump(include=set(_TABLE.names) - {"views"}) | {
        "width": document.img_size[0],
        "height": document.img_size[1],
        "fx": fx,
        "fy": fy,
        "cx": cx,
        "cy": cy,
        "distortion_coefficients": fit.distortion_coefficients,
        "avg_reprojection_error": fit.avg_reprojection_error,
        "uncertainty_rms": fit.uncertainty.rms,
        "views": len(document.views),
        "board_kind": document.board.kind,
        "squares_x": document.board.squares[0],
        "squares_y": document.board.squares[1],
    }


def _points(document: CalibrationDocument) -> Iterator[dict[str, Any]]:
    for view in document.views:
        for corner, (x, y) in zip(view.ids, view.points, strict=True):
            yield {"calibration": document.id, "view": view.index, "corner": corner, "x": x, "y": y}
