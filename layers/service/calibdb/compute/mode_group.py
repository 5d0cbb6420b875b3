"""Group of calibrations that fits views: the mode of a camera whose modes have one key."""

from __future__ import annotations

from calibdb.compute.values import camera_of, views_of
from calibdb.rules.contributed_name import mode_names
from calibdb.schema import CalibrationDocument, ConsensusDocument, FittingGroup, ModeViews
from calibdb.service import Service
from calibsolver import Board, CalibrationError
from calibsolver.consensus.mode import fitting_camera


def fitting_group(service: Service, document: ConsensusDocument, seen: ModeViews) -> FittingGroup | None:
    """Return the one group of calibrations that fits the views, by its most certain calibration.

    None if no group does, or several do. Nothing is stored.
    """
    behind = service.store.consensuses.groups(document)
    if behind is None or len(behind.groups) < 2:
        return None
    ids = [one for group in behind.groups for one in group]
    documents = {d.id: d for d in service.store.calibrations.read(ids)}
    groups = [[documents[one] for one in group if one in documents] for group in behind.groups]
    groups = [group for group in groups if group]
    model = document.distortion_model

    def rank(d: CalibrationDocument) -> tuple[bool, float]:
        return d.distortion_model != model, d.fits[d.distortion_model].uncertainty.rms

    known = [min(group, key=rank).answer() for group in groups]
    try:
        views = views_of(Board.from_record(seen.board), seen.views)
        index = fitting_camera([camera_of(one) for one in known], views, model)
    except (CalibrationError, ValueError):
        return None
    if index is None:
        return None
    calibration = known[index].model_copy(update={"calibrations": len(groups[index])})
    names = mode_names([[(d.counted_as, d.mode_name or "") for d in group] for group in groups])
    return FittingGroup(calibration=calibration, groups=len(known), name=names[index])
