"""The same stack as on AWS, in one process. Its modules are loaded when a name is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.aws.emulator.events import Response
    from tests.aws.emulator.stack import DEVELOPMENT_TOKEN, LocalStack

__all__ = ["DEVELOPMENT_TOKEN", "LocalStack", "Response"]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from tests.aws.emulator import stack

    return getattr(stack, name)
