"""Computations of consensuses by the job `refit`: queued, or awaited."""

import logging

from calibdb.errors import UnavailableError
from calibdb.schema import ConsensusDocument, RefitAnswer, RefitRequest
from calibdb.schema.fields import DistortionModel
from calibdb.store.keys import StreamMode
from calibdb.store.ports import Jobs, encoded

_log = logging.getLogger(__name__)


class Refit:
    """The job `refit`."""

    def __init__(self, jobs: Jobs) -> None:
        self._jobs = jobs

    def later(self, request: RefitRequest) -> None:
        """Queue the computation of the consensus."""
        queued = request.model_copy(update={"queued": True})
        self._jobs.later("refit", encoded(queued))

    def report(self, request: RefitRequest) -> None:
        """Queue misses or an alias to be stored; no error, since no response depends on them."""
        try:
            self.later(request)
        except UnavailableError as error:
            _log.warning("misses or an alias were not reported: %s", error.detail)

    def now(self, request: RefitRequest) -> RefitAnswer:
        """Compute the consensus; raises UnavailableError if that fails."""
        content = self._jobs.now("refit", encoded(request))
        if content is None:
            raise UnavailableError("The service could not compute this model; try again.")
        return RefitAnswer.model_validate_json(content)

    def consensus(self, mode: StreamMode, model: DistortionModel) -> ConsensusDocument | None:
        """Compute the consensus of one model as `now` does; None if there is none."""
        request = RefitRequest(
            camera=mode.camera_key, img_size=mode.img_size, zoom=mode.zoom, models=(model,)
        )
        return self.now(request).models.get(model)
