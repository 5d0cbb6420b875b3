"""The same stack as on AWS, in one process."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.aws.emulator.stack import LocalStack

__all__ = ["LocalStack"]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(name)
    from tests.aws.emulator import stack  # it loads slowly, and other modules here do not need it

    return getattr(stack, name)
