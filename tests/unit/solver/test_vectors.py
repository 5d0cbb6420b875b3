"""Test vectors of lookups and the SDK are what the solver makes today."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from calibsolver import models
from calibsolver.models.planar import Planar
from tests.helpers import vectors


def leaves(value: Any) -> Iterator[Any]:
    """Yield the names and values of a record."""
    if isinstance(value, dict):
        yield from value
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from leaves(part)
    else:
        yield value


@pytest.mark.parametrize(("name", "make"), [("lenses", vectors.lenses), ("pairs", vectors.pairs)])
def test_recorded_vectors_are_the_solvers(name: str, make: Callable[[], Any]) -> None:
    recorded, made = ([*leaves(each)] for each in (vectors.recorded(name), make()))
    assert [leaf for leaf in made if not isinstance(leaf, float)] == [
        leaf for leaf in recorded if not isinstance(leaf, float)
    ]
    ours, theirs = (np.array([leaf for leaf in each if isinstance(leaf, float)]) for each in (made, recorded))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9)


def test_recorded_ray_beyond_the_domain_has_no_pixel() -> None:
    """The tangential part exceeds the stretch."""
    assert vectors.recorded("lenses")[0]["pixels"][0] is None


@pytest.mark.parametrize("model", ["rectilinear", "rational", "omnidirectional"])
def test_planar_models_are_one_to_one_out_to_the_edge_of_the_domain(model: str) -> None:
    circle = np.linspace(0, 2 * np.pi, 60)
    for record in vectors.recorded("lenses"):
        if record["model"] != model:
            continue
        planar, d = models.get(model), np.array(record["k"][4:])
        assert isinstance(planar, Planar)
        for share in (0.2, 0.5, 0.8, 1 - 1e-9):
            r = share * planar.domain_radius(d)
            _, _, ux, uy, vy = planar.distort_plane_jacobian(d, r * np.cos(circle), r * np.sin(circle))
            assert (ux + vy > 0).all()
            assert (ux * vy - uy * uy > 0).all()
