"""What checks on fresh views say of a consensus: when a view fits, who has a vote, what votes decide.

Three that agree confirm a consensus of fewer calibrations than the rule asks for; three that do not withdraw
any, even one that is reliable, until new calibrations agree with it: its lookups lead to the guidance page
then, so that these will come. What is at stake is an answer withheld, never a wrong one given:

* who contributed a calibration of this camera has had their say and votes neither for it nor against;
* votes against count from the newest calibration that agrees on, and as many as there are for it must be
  there, and a tenth of those who contributed to it;
* agreement cannot be bought with empty views: those that would fit any camera are not counted.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable
from dataclasses import dataclass

from calibdb.schema.calibration import Basis
from calibdb.schema.checks import CheckRequest
from calibdb.schema.documents import ConsensusDocument, Votes
from calibdb.schema.lookup import Reason
from calibdb.settings import Thresholds
from calibdb.store.keys import size_text, zoom_text

_FINEST = 1e-4  # of the image's width: errors below it are nobody's concern


@dataclass(frozen=True)
class Finding:
    """What one vote says of the consensus as it is."""

    contributor: str
    time: int
    fits: bool


def fits(error: float, expected: float, noise: float, width: int, ratio: float) -> bool:
    """Tell whether views with this error are of the camera.

    Parameters
    ----------
    error
        px rms of the views under the consensus, the poses alone fitted.
    expected
        px rms of views of the camera under it, as measured when it was made.
    noise
        px rms of the same views under a camera fitted to them: what no camera can do better.
    width
        Of the image, px.
    ratio
        Of the error to what is expected, up to which it fits.
    """
    return error <= ratio * max(expected, noise, _FINEST * width)


def vote_id(request: CheckRequest, camera_key: str, contributor: str, sid: str, now: int, period: int) -> str:
    """Return the name of a vote: the same for all checks that are one vote, of one camera at one size.

    These are a contributor's within `period` seconds; where all are the same contributor (`period` 0), those
    of one session. It sorts by time, to the period.
    """
    # Names of sessions begin with the time of their start.
    voter, moment = (contributor, f"{now // period * period:08x}") if period else (sid, sid[:8])
    what = f"{camera_key}/{size_text(request.img_size)}/{zoom_text(request.zoom)}/{voter}"
    return moment + hashlib.sha256(what.encode()).hexdigest()[:12]


def tally(findings: Iterable[Finding], since: int, contributors: frozenset[str], *, apart: bool) -> Votes:
    """Count votes: those against a consensus from `since` on alone.

    Parameters
    ----------
    findings
        Newest first.
    since
        Unix seconds of the newest calibration in the group that agrees.
    contributors
        Whose calibrations were considered.
    apart
        Whether contributors can be told apart: each then has one vote, the newest.
    """
    agree = disagree = 0
    heard: set[str] = set()
    for finding in findings:
        if apart and (finding.contributor in heard or finding.contributor in contributors):
            continue
        heard.add(finding.contributor)
        if finding.fits:
            agree += 1
        elif finding.time >= since:
            disagree += 1
    return Votes(agree=agree, disagree=disagree)


def judged(
    found: Reason | None, votes: Votes, thresholds: Thresholds, *, confirmable: bool, contributors: int
) -> tuple[Reason | None, Basis | None]:
    """Return why a consensus is not reliable, or what makes it so.

    Parameters
    ----------
    found
        Why its calibrations alone do not make it reliable.
    votes
        What checks said.
    thresholds
        The deployment's.
    confirmable
        Whether more calibrations like these are all that is missing.
    contributors
        Of the group that agrees.
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
    """Return the consensus as `votes` leave it, resting on `basis`."""
    calibration = document.calibration
    if calibration is None:
        return document.model_copy(update={"votes": votes, "basis": basis, "reason": document.found})
    reason, why = judged(
        document.found,
        votes,
        thresholds,
        confirmable=document.confirmable,
        contributors=calibration.contributors,
    )
    answer = calibration.model_copy(update={"reliable": reason is None, "basis": why})
    return document.model_copy(
        update={"votes": votes, "basis": basis, "reason": reason, "calibration": answer}
    )
