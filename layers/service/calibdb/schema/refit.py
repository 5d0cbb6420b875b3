"""The internal call of `refit`: which consensus to compute, and what came out."""

from __future__ import annotations

from pydantic import Field

from calibdb.schema.calibration import Calibration
from calibdb.schema.documents import ConsensusDocument, ViewDocument
from calibdb.schema.fields import DistortionModel, ImgSize, Label, Members, Open, Zoom


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
    be asked by it. `queued`: nobody waits for the answer, so that whoever computes already can do it along.
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


class FittingGroup(Open):
    """Most certain calibration of the one group that fits views, and the number of groups."""

    calibration: Calibration
    groups: int


class RefitAnswer(Open):
    """Answer by model: the consensus now stored, or null where there is no calibration at all."""

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
