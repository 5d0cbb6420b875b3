"""Load of a dump into a stack, which then gives the same answers."""

import functools
from collections.abc import Iterator
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from calibdb.schema import CalibrationDocument, RigCalibrationDocument, VoteDocument
from infra.console import track
from infra.ops import OpsError, reindex
from infra.ops.context import OpsContext

CALIBRATIONS, VOTES, RIGS = "calibrations.jsonl", "votes.jsonl", "rigs.jsonl"

Document = TypeVar("Document", bound=BaseModel)


def load(context: OpsContext, folder: Path, *, dry_run: bool = False) -> tuple[int, int]:
    """Store what `dump` wrote, have every consensus computed; return the numbers of calibrations and votes.

    Known ids stay as they are, so a load that was cut short is repeated. Contributors of a dump are other
    ones than those known here. With `dry_run`, the files are only read. Raises OpsError, and has stored
    nothing, if a line is neither a calibration nor a vote.
    """
    if not (folder / CALIBRATIONS).is_file():
        raise OpsError(f"{folder} lacks {CALIBRATIONS}: it is not the folder of a dump")
    read_calibrations = functools.partial(_lines, folder / CALIBRATIONS, CalibrationDocument)
    read_votes = functools.partial(_lines, folder / VOTES, VoteDocument)
    # Every line is read once before the first is stored.
    calibrations = sum(1 for _ in track(read_calibrations(), "reading calibrations"))
    votes = sum(1 for _ in track(read_votes(), "reading votes"))
    rigs = list(_lines(folder / RIGS, RigCalibrationDocument))
    if dry_run:
        return calibrations, votes
    modes = set()
    for document in track(read_calibrations(), "calibrations", calibrations):
        context.store.calibrations.publish(document)
        modes.add(reindex.mode_of(document))
    for vote in track(read_votes(), "votes", votes):
        context.store.votes.cast(vote)
    for rig in rigs:
        context.store.rigs.publish(rig)
    ordered = sorted(modes, key=lambda mode: (mode.camera_key, mode.text))
    failed = sum(reindex.refit(context, mode) is None for mode in track(ordered, "consensuses", len(ordered)))
    if failed:
        raise OpsError(f"of {failed} modes the consensus could not be computed; run `reindex`")
    return calibrations, votes


def _lines(path: Path, model: type[Document]) -> Iterator[Document]:
    if not path.is_file():
        return
    with path.open(encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            try:
                yield model.model_validate_json(line)
            except ValidationError as error:
                what = error.errors(include_url=False)[0]
                place = ".".join(map(str, what["loc"])) or "the line"
                raise OpsError(f"{path}, line {number}: {place}: {what['msg']}") from error
