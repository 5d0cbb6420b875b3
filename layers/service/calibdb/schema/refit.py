"""The internal call of `refit`: which consensus to compute, and what came out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import Field

from calibdb.schema.calibration import Calibration
from calibdb.schema.documents import ConsensusDocument, ViewDocument
from calibdb.schema.fields import DistortionModel, ImgSize, Label, Members, Open, Zoom

if TYPE_CHECKING:
    from calibdb.schema.lookup import LookupRequest


class NewAlias(Open):
    """Label and platform under which a lookup found a camera, and the hashed source of the lookup."""

    label: Label
    platform: Label
    source: str


class ModeViews(Open):
    """Views that may tell in which mode a camera is, and the record of their board."""

    board: Members
    views: tuple[ViewDocument, ...]


class RefitRequest(Open):
    """One camera (its key) at one size and zoom, and the models to compute.

    A model that the function does not know is passed over: while a new version is rolled out, an old one may
    be asked by it. `queued`: no caller waits for the answer, so that a running computation can include it.
    `alias`: nothing is computed; an alias of the camera is stored. `misses`: nothing is computed
    either; cameras, and how often lookups found nothing reliable of them. `seen`: views to which one of the
    groups of calibrations of the first model is fitted; nothing is stored.
    """

    camera: str
    img_size: ImgSize
    zoom: Zoom = 0.0
    models: tuple[str, ...] = ()  # empty: all
    queued: bool = False
    alias: NewAlias | None = None
    misses: dict[str, int] = Field({}, max_length=200)
    seen: ModeViews | None = None

    @classmethod
    def of_views(cls, camera: str, request: LookupRequest) -> RefitRequest:
        """Return the request for the group of a camera's calibrations that fits the views of a lookup."""
        views = (ViewDocument(index=n, ids=v.ids, points=v.points) for n, v in enumerate(request.views))
        return cls(
            camera=camera,
            img_size=request.img_size,
            zoom=request.zoom,
            models=(request.distortion_model,),
            seen=ModeViews(board=request.board.model_dump(mode="json"), views=tuple(views)),
        )


class FittingGroup(Open):
    """Most certain calibration of the one group that fits views, the number of groups, and its name."""

    calibration: Calibration
    groups: int
    name: str | None = None


class RefitAnswer(Open):
    """Answer by model: the consensus now stored, or null if there is no calibration at all."""

    models: dict[DistortionModel, ConsensusDocument | None]
    fitting: FittingGroup | None = None


class ListedObject(Open):
    """An object as S3 lists it."""

    key: str = Field(alias="Key")


class BackfillBatch(Open):
    """Input that a distributed map of Step Functions hands to each of its children."""

    items: tuple[ListedObject, ...] = Field(alias="Items")


class BackfillAnswer(Open):
    """Request to `refit`."""

    requests: tuple[RefitRequest, ...]
