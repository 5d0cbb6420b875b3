"""Selection of tests by marker and environment, the profile of Hypothesis, and the collector of garbage."""

import gc
import os

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers
from xdist.remote import Producer
from xdist.scheduler import LoadScopeScheduling

from tests.helpers.data import EXTERNAL

THOROUGH = bool(os.environ.get("THOROUGH"))  # `make thorough`

#: markers whose tests run only on a condition
SELECTED = {"thorough": THOROUGH, "external_data": EXTERNAL is not None}

#: modules that take longest: what begins last must be short
LONGEST = (
    *("test_all_pages", "test_virtual_camera", "test_result", "test_interruptions", "test_controls"),
    *("test_pages", "test_board", "test_ar", "test_rig", "test_developers"),
    *("test_import", "test_guidance", "test_hostile", "test_boards_in_pictures", "test_live_capture"),
    *("test_location", "test_documents", "test_server_wheel", "test_durability", "test_iam"),
)

#: allocations between two searches for garbage. Storage in memory makes so many objects that Python's own 700
#: took a fifth of the processor's time.
MIN_ALLOCATIONS = 20_000

# What modules define stays: nothing of it is garbage, until tests run (`pytest_runtestloop`).
gc.disable()

# The same examples each time, however slow the machine is; new ones are looked for where there is time.
settings.register_profile(
    "calibdb", deadline=None, derandomize=not THOROUGH, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("calibdb")
if not THOROUGH:
    # Hypothesis draws constants of the modules that are loaded: the order of tests would choose the examples.
    providers._get_local_constants = lambda: providers._local_constants  # stays empty


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    unwanted = {name for name, wanted in SELECTED.items() if not wanted}
    deselected = [item for item in items if unwanted & {mark.name for mark in item.iter_markers()}]
    if deselected:
        config.hook.pytest_deselected(items=deselected)
        gone = set(deselected)
        items[:] = [item for item in items if item not in gone]
    first = {f"{name}.py": place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: first.get(item.path.name, len(first)))


class ModulesAndFirefox(LoadScopeScheduling):
    """Scheduler of whole modules, and of all tests in Firefox, which takes long to start, for one worker."""

    def _split_scope(self, nodeid: str) -> str:
        return "in_firefox" if "in_firefox" in nodeid else super()._split_scope(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Producer) -> LoadScopeScheduling | None:
    return ModulesAndFirefox(config, log) if config.getvalue("dist") == "loadscope" else None


def pytest_configure() -> None:
    if EXTERNAL is not None and not EXTERNAL.is_dir():
        raise pytest.UsageError(f"CALIBDB_DATA names no folder: {EXTERNAL}")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish() -> None:
    """Collect what is left once. pytest does it five times, which other interpreters may need."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop() -> None:
    """Collect garbage from here on, of what tests make."""
    gc.freeze()
    gc.set_threshold(MIN_ALLOCATIONS, *gc.get_threshold()[1:])
    gc.enable()
