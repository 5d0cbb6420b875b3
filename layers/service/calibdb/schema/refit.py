"""The internal call of `refit`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic import Field

from calibdb.schema.calibration import Calibration
from calibdb.schema.documents import ConsensusDocument, ViewDocument
from calibdb.schema.fields import DistortionModel, ImgSize, Label, Members, Open, Zoom

if TYPE_CHECKING:
    from calibdb.schema.lookup import LookupRequest


class NewAlias(Open):
    """Label and platform under which a lookup found a camera, and its hashed source."""

    label: Label
    platform: Label
    source: str


class ModeViews(Open):
    """Views that may show the mode of a camera, and the record of their board."""

    board: Members
    views: tuple[ViewDocument, ...]


class RefitRequest(Open):
    """One camera (its key) at one size and zoom, and the models to compute.

    Unknown models are ignored: during a rollout a newer version may ask. With `alias` or `misses` nothing is
    computed: they are stored. With `seen` nothing is stored: the group of calibrations that fits is returned.
    """

    camera: str
    img_size: ImgSize
    zoom: Zoom = 0.0
    models: tuple[str, ...] = ()  # empty: all
    queued: bool = False  # no caller waits, so that a running computation can include it
    alias: NewAlias | None = None
    misses: dict[str, int] = Field({}, max_length=200)  # lookups without a reliable result, by camera
    seen: ModeViews | None = None

    @classmethod
    def of_views(cls, camera: str, request: LookupRequest) -> RefitRequest:
        """Request for the group of calibrations that fits the views of a lookup."""
        views = (ViewDocument(index=n, ids=v.ids, points=v.points) for n, v in enumerate(request.views))
        return cls(
            camera=camera,
            img_size=request.img_size,
            zoom=request.zoom,
            models=(request.distortion_model,),
            seen=ModeViews(board=request.board.model_dump(mode="json"), views=tuple(views)),
        )


class FittingGroup(Open):
    """Most certain calibration of the group that fits views, the number of groups, and its name."""

    calibration: Calibration
    groups: int
    name: str | None = None


class RefitAnswer(Open):
    """Stored consensus by model; None if there is no calibration at all."""

    models: dict[DistortionModel, ConsensusDocument | None]
    fitting: FittingGroup | None = None


class ListedObject(Open):
    """An object as S3 lists it."""

    key: str = Field(alias="Key")


class BackfillBatch(Open):
    """Input of a child of a distributed map of Step Functions."""

    items: tuple[ListedObject, ...] = Field(alias="Items")


class BackfillAnswer(Open):
    """Request to `refit`."""

    requests: tuple[RefitRequest, ...]
