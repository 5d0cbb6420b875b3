"""Invocations of `refit`, which computes consensuses: queued, or awaited."""

from __future__ import annotations

from typing import TYPE_CHECKING

from calibdb.errors import UnavailableError
from calibdb.schema import RefitAnswer, RefitRequest
from calibdb.store.clients import available

if TYPE_CHECKING:
    from collections.abc import Callable

    from mypy_boto3_lambda import LambdaClient


class Refit:
    """The internal function, by its name."""

    def __init__(self, client: Callable[[], LambdaClient], function: str | None) -> None:
        self._client = client
        self._function = function

    def later(self, request: RefitRequest) -> None:
        """Have the consensus computed; returns once the request is queued."""
        queued = request.model_copy(update={"queued": True})
        with available():
            self._client().invoke(
                FunctionName=self._name(), InvocationType="Event", Payload=queued.model_dump_json().encode()
            )

    def now(self, request: RefitRequest) -> RefitAnswer:
        """Have the consensus computed and return it; raises UnavailableError when that fails."""
        with available():
            answer = self._client().invoke(
                FunctionName=self._name(),
                InvocationType="RequestResponse",
                Payload=request.model_dump_json().encode(),
            )
            content = answer["Payload"].read()
        if "FunctionError" in answer:
            raise UnavailableError("The service could not compute this model; try again.")
        return RefitAnswer.model_validate_json(content)

    def _name(self) -> str:
        if self._function is None:
            raise ValueError("REFIT_FUNCTION is not set for a function that needs it")
        return self._function
