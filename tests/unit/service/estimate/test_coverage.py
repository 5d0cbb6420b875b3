"""Coverage and width of intervals, over every camera of the table, each left out."""

import statistics

import pytest

from tests.bench import estimates
from tests.bench.estimates import Case


@pytest.fixture(scope="module")
def cases() -> dict[str, list[Case]]:
    """Cases of each basis that need the committed table only."""
    steps = [step for name, step in estimates.STEPS.items() if name != "action cameras"]
    every = [case for step in steps for case in step() if not case.group.startswith(estimates.FILES)]
    return estimates.grouped(every, lambda case: case.basis)


@pytest.mark.parametrize("basis", ["calibrations", "other_size", "published", "family", "population"])
def test_intervals_of_90_percent_contain_85_to_95(cases: dict[str, list[Case]], basis: str) -> None:
    assert len(cases[basis]) >= 20
    share = statistics.mean(case.holds for case in cases[basis])
    assert 0.85 <= share <= 0.95


@pytest.mark.parametrize("basis", ["published", "family", "population"])
def test_intervals_of_each_kind_contain_85_to_95(cases: dict[str, list[Case]], basis: str) -> None:
    groups = estimates.grouped(cases[basis], lambda case: case.group)
    large = {group: own for group, own in groups.items() if len(own) >= 20}
    assert large
    for group, own in large.items():
        assert 0.85 <= statistics.mean(case.holds for case in own) <= 0.95, group


@pytest.mark.parametrize(
    ("basis", "group", "width"),
    [("published", "", 0.08), ("family", "phones, rear", 0.20), ("population", "", 0.45)],
)
def test_intervals_of_live_cameras_are_narrow(
    cases: dict[str, list[Case]], basis: str, group: str, width: float
) -> None:
    assert statistics.median(case.width for case in cases[basis] if group in case.group) <= width
