"""Initial camera of a capture, from what others measured."""

from __future__ import annotations

from collections.abc import Sequence

from calibdb.schema import ConsensusDocument, FitRecord


def find_seed(
    consensuses: Sequence[ConsensusDocument], img_size: tuple[int, int], zoom: float, model: str
) -> FitRecord | None:
    """Find the reliable consensus of this camera at this size, zoom and model.

    A capture starts from this initial camera, which is not part of its result and need not be right. What is
    not reliable starts nothing: it may be one person's, of another camera.
    """
    for consensus in consensuses:
        same = (consensus.img_size, consensus.zoom, consensus.distortion_model) == (img_size, zoom, model)
        if same and consensus.reliable and consensus.calibration is not None:
            return FitRecord.model_validate(consensus.calibration.model_dump())
    return None
