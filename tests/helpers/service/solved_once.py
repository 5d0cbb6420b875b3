"""Computations of the solver, each made once in a process for the same arguments.

They are pure functions. Captures of the same simulated camera, and retries of a request that failed, ask for
the same fits and target poses again. Servers in other processes compute everything.
"""

import functools
import hashlib
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from importlib import import_module
from types import NoneType
from typing import Any

import numpy as np
import pytest

from calibsolver import deadline
from calibsolver.consensus import agreement, location
from calibsolver.fitting import calibration, coverage, rivals, uncertainty
from calibsolver.fitting.fit import _Fit
from calibsolver.guidance.projection_uncertainty import ProjectionUncertainty
from calibsolver.models import Model
from calibsolver.rig.fit import _RigFit

estimate = import_module("calibsolver.rig.estimate")  # whose package has a function of this name
JACOBIAN = "projection_jacobian_rotation_free"
USERS_OF_JACOBIAN = (agreement, calibration, coverage, estimate, location, rivals, uncertainty)
#: owner, name and code of each function that is remembered, as it is without this module
PURE: tuple[tuple[Any, str, Callable[..., Any]], ...] = tuple(
    (owner, name, getattr(owner, name))
    for owner, name in (
        (_Fit, "run"),
        (_RigFit, "run"),
        (ProjectionUncertainty, "choose"),
        (estimate, "next_moment"),
        (estimate, "held_out_rms"),
        *((module, JACOBIAN) for module in USERS_OF_JACOBIAN),
    )
)

_results: dict[tuple[str, bytes], Any] = {}
_locks: defaultdict[tuple[str, bytes], threading.Lock] = defaultdict(threading.Lock)


@contextmanager
def solved_once() -> Iterator[None]:
    """Remember results within the block, and those of earlier blocks."""
    with pytest.MonkeyPatch.context() as patch:
        for owner, name, function in PURE:
            patch.setattr(owner, name, _remembered(function))
        yield


def _remembered(function: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(function)
    def remembered(*arguments: Any, **named: Any) -> Any:
        digest = hashlib.blake2b()
        _feed(digest.update, (arguments, named))
        key = function.__qualname__, digest.digest()
        with _locks[key]:
            if key in _results:
                deadline.check()  # a request without time left gets no result
            else:
                _results[key] = _read_only(function(*arguments, **named))
            return _results[key]

    return remembered


def _read_only(result: Any) -> Any:
    if isinstance(result, np.ndarray):
        result.setflags(write=False)
    return result


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
        case ProjectionUncertainty():
            _feed(update, (value.board, value.img_size, value.model, value.seed))
        case _ if is_dataclass(value):
            for field in fields(value):
                _feed(update, getattr(value, field.name))
        case _:
            raise TypeError(f"{type(value)} is not known here")
    update(b")")
