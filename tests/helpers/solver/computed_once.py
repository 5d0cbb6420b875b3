"""Fits, judgements of views and target poses, each computed once in a process for the same arguments.

They are pure functions. Captures of the same simulated camera ask for the same ones again and again, and so
do conversions of the same calibration. Servers in other processes compute everything.
"""

import copy
import functools
import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from importlib import import_module
from types import NoneType
from typing import Any, ParamSpec, TypeVar

import numpy as np
import pytest

from calibsolver import deadline, fit
from calibsolver.capture import Capture
from calibsolver.fitting.fit import _Fit
from calibsolver.guidance.projection_uncertainty import ProjectionUncertainty
from calibsolver.models import Model
from calibsolver.quality import report, rivals
from calibsolver.rig.fit import _RigFit

PURE: tuple[tuple[Any, str], ...] = (
    (_Fit, "run"),
    (_RigFit, "run"),
    (ProjectionUncertainty, "choose"),
    (Capture, "judge"),
    (rivals, "with_rivals"),
    (report, "describe"),
    (import_module("calibsolver.rig.estimate"), "next_moment"),  # whose package has a function of that name
)

P = ParamSpec("P")
T = TypeVar("T")

_results: dict[bytes, Any] = {}


@contextmanager
def computed_once() -> Iterator[None]:
    """Remember what is computed in the block, and recall what earlier blocks computed."""
    with pytest.MonkeyPatch.context() as patch:
        for owner, name in PURE:
            patch.setattr(owner, name, remembered(getattr(owner, name)))
        yield


def remembered(function: Callable[P, T]) -> Callable[P, T]:
    """Wrap a pure function so that it is called once for the same arguments."""

    @functools.wraps(function)
    def recall(*arguments: P.args, **named: P.kwargs) -> T:
        deadline.check()  # a request without time left gets no result
        digest = hashlib.blake2b(f"{function.__module__}.{function.__qualname__}".encode())
        _feed(digest.update, (arguments, named))
        key = digest.digest()
        if key not in _results:
            _results[key] = function(*arguments, **named)
        result: T = _results[key]
        return copy.deepcopy(result) if isinstance(result, dict) else result

    return recall


fit_once = remembered(fit)


def _feed(update: Callable[[bytes], None], value: Any) -> None:
    """Pass on bytes that differ where values do; TypeError of a type that is not known here."""
    update(f"{type(value).__qualname__}(".encode())
    match value:
        case np.ndarray():
            update(f"{value.shape}{value.dtype}".encode())
            update(np.ascontiguousarray(value).tobytes())
        case bool() | int() | float() | str() | np.generic() | NoneType():
            update(repr(value).encode())
        case Model():
            update(value.name.encode())
        case Mapping():
            _feed(update, list(value.items()))
        case list() | tuple():
            for one in value:
                _feed(update, one)
        case Capture():
            _feed(update, (value.board, value.img_size, value.model, value.guidance))
            _feed(update, (value.target_error, value.seed, value.recorded))
        case ProjectionUncertainty():
            _feed(update, (value.board, value.img_size, value.model, value.seed))
        case _ if is_dataclass(value):
            for field in fields(value):
                _feed(update, getattr(value, field.name))
        case _:
            raise TypeError(f"{type(value)} is not known here")
    update(b")")
