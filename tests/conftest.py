"""Selection of tests by marker and environment, and the profile of Hypothesis."""

import os

import pytest
from hypothesis import HealthCheck, settings

from tests.helpers.data import EXTERNAL

THOROUGH = bool(os.environ.get("THOROUGH"))  # `make thorough`

#: markers whose tests run only on a condition
SELECTED = {"thorough": THOROUGH, "external_data": EXTERNAL is not None}

#: modules that take longest, half a minute of processor time to ten seconds: what begins last must be short
LONGEST = (
    *("test_guidance", "test_reindex", "test_crowd", "test_hostile", "test_ops", "test_durability"),
    *("test_loop", "test_pooling", "test_killed_while_finishing", "test_edge_histories", "test_bundle"),
    "test_openapi_fuzz",
)

# The same examples each time, however slow the machine is; new ones are looked for where there is time.
settings.register_profile(
    "calibdb", deadline=None, derandomize=not THOROUGH, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("calibdb")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    unwanted = {name for name, wanted in SELECTED.items() if not wanted}
    deselected = [item for item in items if unwanted & {mark.name for mark in item.iter_markers()}]
    if deselected:
        config.hook.pytest_deselected(items=deselected)
        gone = set(deselected)
        items[:] = [item for item in items if item not in gone]
    first = {f"{name}.py": place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: first.get(item.path.name, len(first)))


def pytest_configure() -> None:
    if EXTERNAL is not None and not EXTERNAL.is_dir():
        raise pytest.UsageError(f"CALIBDB_DATA names no folder: {EXTERNAL}")
