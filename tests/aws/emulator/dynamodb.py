"""moto's DynamoDB, asked without the HTTP around it.

moto finds the service by the address, the operation by a header and its method by looking through its class,
anew for each request: more work than the operation. All three are known here.
"""

from __future__ import annotations

import functools
from typing import Any

from botocore.awsrequest import AWSPreparedRequest
from moto.core import responses, utils
from moto.core.loaders import create_loader
from moto.core.parse import PROTOCOL_PARSERS
from moto.core.utils import get_service_model, method_names_from_class
from moto.dynamodb.responses import DynamoHandler
from werkzeug.exceptions import HTTPException

from infra.deploy.intrinsics import ACCOUNT, REGION

# moto asks which methods its handler has at each request.
responses.method_names_from_class = functools.cache(method_names_from_class)  # type: ignore[attr-defined]
# A loader looks through the folders of all of AWS's services; moto makes one for each.
utils.create_loader = functools.cache(create_loader)  # type: ignore[attr-defined]


class _Handler(DynamoHandler):
    """moto's handler of one request, with what it would have read from address and headers."""

    def __init__(self, operation: str, body: object):
        super().__init__()
        self.headers = {"Content-Type": "application/x-amz-json-1.0"}
        self.response_headers = {}
        self.current_account, self.region = ACCOUNT, REGION
        self._operation = operation
        model = get_service_model("dynamodb").operation_model(operation)
        read: Any = {"body": body}  # of this protocol nothing else is read
        self.params = PROTOCOL_PARSERS["json"](model).parse(read)

    def _get_action(self) -> str:
        return self._operation

    @staticmethod
    def _enrich_response(headers: dict[str, str], body: str) -> tuple[dict[str, str], str]:
        """Add no request id: nobody reads it."""
        return headers, body


def ask(operation: str, request: AWSPreparedRequest) -> tuple[int, dict[str, str], bytes | str]:
    """Answer a request: status, headers and body. Not safe from two threads at once."""
    try:
        status, headers, body = _Handler(operation, request.body).call_action()
    except HTTPException as error:
        return error.code or 500, dict(error.get_headers()), error.get_body()
    return status, headers, body
