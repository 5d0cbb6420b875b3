"""Clients of AWS whose paginators return given pages."""

from typing import Any
from unittest.mock import Mock


def paged(*pages: dict[str, Any], **responses: Any) -> Mock:
    """Make a client; `responses`: those of its other calls, by name."""
    client = Mock()
    client.get_paginator.return_value.paginate.return_value = pages
    for name, response in responses.items():
        getattr(client, name).return_value = response
    return client
