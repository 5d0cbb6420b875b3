"""Models that are built at their first use: a Lambda function uses few of them."""

from __future__ import annotations

import threading
from typing import Any

from pydantic import BaseModel, ConfigDict

building = threading.RLock()
"""Lock of the thread that builds a model, with those of its fields."""


class Deferred(BaseModel):
    """Model whose validator is built at its first use, by one thread at a time: pydantic has no lock."""

    model_config = ConfigDict(defer_build=True)

    @classmethod
    def model_rebuild(
        cls,
        *,
        force: bool = False,
        raise_errors: bool = True,
        _parent_namespace_depth: int = 2,
        _types_namespace: Any = None,
    ) -> bool | None:
        """Build validator and serializer as pydantic does."""
        with building:
            return super().model_rebuild(
                force=force,
                raise_errors=raise_errors,
                _parent_namespace_depth=_parent_namespace_depth + 1,  # this method's own frame
                _types_namespace=_types_namespace,
            )
