"""Load of a dump into a stack, which then gives the same answers."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from calibdb.schema import CalibrationDocument, VoteDocument
from infra.ops import reindex
from infra.ops.context import OpsContext
from infra.ops.errors import OpsError

CALIBRATIONS, VOTES = "calibrations.jsonl", "votes.jsonl"

Document = TypeVar("Document", bound=BaseModel)


def load(context: OpsContext, folder: Path) -> tuple[int, int]:
    """Store what `dump` wrote and have every consensus computed; return how many calibrations and votes.

    What is there already under its id stays as it is, so that a load that was cut short is simply repeated.
    Into a stack that is not empty: contributors of a dump are other ones than those known here.

    Raises OpsError, and has stored nothing, where a line is no calibration or no vote.
    """
    if not (folder / CALIBRATIONS).is_file():
        raise OpsError(f"{folder} holds no {CALIBRATIONS}: it is not the folder of a dump")
    for _ in chain(_lines(folder / CALIBRATIONS, CalibrationDocument), _lines(folder / VOTES, VoteDocument)):
        pass  # every line is read once before the first is stored
    modes = set()
    calibrations = votes = 0
    for document in _lines(folder / CALIBRATIONS, CalibrationDocument):
        context.store.calibrations.publish(document)
        modes.add(reindex.mode_of(document))
        calibrations += 1
    for vote in _lines(folder / VOTES, VoteDocument):
        context.store.votes.cast(vote)
        votes += 1
    failed = sum(
        reindex.refit(context, mode) is None for mode in sorted(modes, key=lambda m: (m.camera_key, m.text))
    )
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
