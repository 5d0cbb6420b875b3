"""Votes on a consensus by checks on fresh views: when views fit, who has a vote, and what votes decide.

Three votes for a consensus confirm it although it has few calibrations. Three votes against it since its
newest calibration withdraw it until new calibrations agree with it, if they are as many as those for it and a
third of its contributors. Votes can withhold an answer, but never make a wrong one:

* contributors of a calibration of this camera do not vote, nor do images of a calibration;
* a consensus is measured by the checker's own data, since its makers choose the noise behind it.
"""

import hashlib
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from calibdb.schema.calibration import Basis
from calibdb.schema.checks import CheckRequest
from calibdb.schema.documents import ConsensusDocument, Votes
from calibdb.schema.fields import IPV6_SOURCE, size_text, zoom_text
from calibdb.schema.lookup import Reason
from calibdb.settings import Thresholds

_NOISE_FLOOR_WIDTHS = 1e-4  # of the width: smaller errors do not matter
_MAX_EXCESS_WIDTHS = 5e-4  # of the width: error beyond the noise that no ratio excuses
_SPECIMEN_SPREAD_WIDTHS = 4e-3  # of the width, rms over the image: specimens of one product differ by that
_MAX_SIGMAS = 3.0  # standard deviations of the views' own camera
_MAX_INFORMATIVE_WIDTHS = 2e-3  # of the width: predicted error up to which a camera is informative


@dataclass(frozen=True)
class OwnCamera:
    """Camera determined by the views: px rms from the consensus, and predicted."""

    difference: float
    uncertainty: float


@dataclass(frozen=True)
class Finding:
    """Weight of one vote for the current consensus."""

    source: str
    time: int
    fits: bool


def is_explained(error: float, noise: float, width: int, ratio: float) -> bool:
    """True if a consensus explains views that have this error, px rms, under it; only poses are fitted.

    `noise`: px rms of the same views under a camera fitted to them.
    """
    return error <= min(ratio * expected_error(noise, width), math.hypot(noise, _MAX_EXCESS_WIDTHS * width))


def expected_error(noise: float, width: int) -> float:
    """Predicted error, px rms, of views of this noise under their own camera."""
    return max(noise, _NOISE_FLOOR_WIDTHS * width)


def decide_vote(
    error: float, noise: float, width: int, ratio: float, own: OwnCamera | None, *, same_model: bool
) -> bool | None:
    """Decide whether views vote for a consensus (True), against it (False), or neither (None).

    `own`: the camera that the views determine, if they do. One of another model may differ where the views do
    not reach; then a difference is no vote.
    """
    if not is_explained(error, noise, width, ratio):
        return False
    if (
        own is None
        or not math.isfinite(own.difference)
        or not own.uncertainty <= _MAX_INFORMATIVE_WIDTHS * width
    ):
        return None
    if own.difference <= math.hypot(_SPECIMEN_SPREAD_WIDTHS * width, _MAX_SIGMAS * own.uncertainty):
        return True
    return False if same_model else None


def view_digest(ids: Sequence[int], points: Sequence[Sequence[float]]) -> str:
    """Digest of a view's corners."""
    corners = sorted((i, round(x, 3), round(y, 3)) for i, (x, y) in zip(ids, points, strict=True))
    return hashlib.sha256(repr(corners).encode()).hexdigest()[:8]


def vote_id(request: CheckRequest, camera_key: str, source: str, sid: str, now: int, period: int) -> str:
    """Id of a vote: the same for all checks that are one vote, of one camera at one size.

    These are a source's within `period` seconds, or a session's if all are the same contributor (`period` 0).
    """
    # Names of sessions begin with the time of their start.
    voter, moment = (source, f"{now // period * period:08x}") if period else (sid, sid[:8])
    what = f"{camera_key}/{size_text(request.img_size)}/{zoom_text(request.zoom)}/{voter}"
    return moment + hashlib.sha256(what.encode()).hexdigest()[:12]


def tally(findings: Iterable[Finding], since: int, sources: frozenset[str], *, one_per_source: bool) -> Votes:
    """Count `findings`, the newest first.

    Those against count only from `since` on, unix seconds of the newest calibration that agrees.
    `sources`: of the considered calibrations. `one_per_source`: True if contributors can be distinguished.
    """
    agree: list[str] = []
    disagree: list[str] = []
    heard: set[str] = set()
    for finding in findings:
        if one_per_source and (finding.source in heard or finding.source in sources):
            continue
        heard.add(finding.source)
        if finding.fits:
            agree.append(finding.source)
        elif finding.time >= since:
            disagree.append(finding.source)
    count = count_lines if one_per_source else len
    return Votes(agree=count(agree), disagree=count(disagree))


def decide_reliability(
    found: Reason | None, votes: Votes, thresholds: Thresholds, *, confirmable: bool, contributors: int
) -> tuple[Reason | None, Basis | None]:
    """Decide why a consensus is not reliable, or on what basis it is.

    `found`: reason by its calibrations. `confirmable`: True if only more of these are missing.
    """
    doubts = max(thresholds.min_votes, math.ceil(thresholds.min_doubt * contributors))
    if votes.disagree >= doubts and votes.disagree >= votes.agree:
        return "disagree", None
    if found is None:
        return None, "consensus"
    if confirmable and votes.agree >= thresholds.min_votes:
        return None, "checked"
    return found, None


def with_votes(
    document: ConsensusDocument, votes: Votes, basis: str, thresholds: Thresholds
) -> ConsensusDocument:
    """Apply `votes` to a consensus; `basis`: digest of its inputs."""
    calibration = document.calibration
    if calibration is None:
        return document.model_copy(update={"votes": votes, "basis": basis, "reason": document.found})
    reason, why = decide_reliability(
        document.found,
        votes,
        thresholds,
        confirmable=document.confirmable,
        contributors=calibration.contributors,
    )
    answer = calibration.model_copy(update={"reliable": reason is None, "basis": why})
    changed = {"votes": votes, "basis": basis, "reason": reason, "calibration": answer}
    return document.model_copy(update=changed)


def family(source: str) -> str:
    """Address family of a source."""
    return "ipv6" if source.startswith(IPV6_SOURCE) else "ipv4"


def count_lines(sources: Iterable[str]) -> int:
    """Number of different sources in the larger family of addresses.

    A line with both an IPv4 and an IPv6 address must not count twice.
    """
    return max(Counter(map(family, set(sources))).values(), default=0)
