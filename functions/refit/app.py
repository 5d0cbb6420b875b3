"""Refit: the consensus of the calibrations of one camera, at one size and zoom. Internal.

It is idempotent, and safe late or concurrently: a result is written only over one made from less. If another
request from the queue has the single-flight lease, its holder repeats the work.
"""

import json
from typing import Any

from calibdb.compute.refits import Consensuses, ModeRefit, fitting_group
from calibdb.compute.values import time_limit
from calibdb.http import metrics
from calibdb.schema import DISTORTION_MODELS, RefitAnswer, RefitRequest
from calibdb.service import Service
from calibdb.store import StreamMode
from calibdb.store.aliases import Alias

MIN_PUBLISHING_S = 8.0  # for storage and the answer


@metrics.counting_denied_reads
def handler(event: dict[str, Any], context: Any) -> dict[str, Any]:
    """Compute, store and return the consensuses of the requested models."""
    if "Records" in event:  # from the dead-letter queue
        (record,) = event["Records"]
        event = json.loads(record["body"])["requestPayload"]
    request = RefitRequest.model_validate(event)
    service = Service.of_process()
    refit = ModeRefit(service, StreamMode(request.camera, request.img_size, request.zoom), context)
    consensuses: Consensuses = {}
    fitting = None
    with time_limit(lambda: context.get_remaining_time_in_millis() / 1000 - MIN_PUBLISHING_S):
        if request.misses:
            service.store.miss_counts.add(request.misses, service.now)
        elif request.alias is not None:
            alias = Alias(request.alias.label, request.alias.platform)
            service.store.aliases.record(alias, request.camera, request.alias.source, service.now)
        elif request.queued:
            refit.under_lease()
        else:
            models = [m for m in DISTORTION_MODELS if m in request.models or not request.models]
            consensuses = refit.for_caller(models)
            document = consensuses.get(models[0]) if request.seen and models else None
            if document and request.seen:
                fitting = fitting_group(service.store, document, request.seen)
    return RefitAnswer.model_validate({"models": consensuses, "fitting": fitting}).model_dump(mode="json")
