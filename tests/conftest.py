"""What holds for all tests: which are left out, and that none of them fails by chance."""

import os

import pytest
from hypothesis import HealthCheck, settings

THOROUGH = bool(os.environ.get("THOROUGH"))  # `make thorough`

# The same examples each time, however slow the machine is; new ones are looked for where there is time.
settings.register_profile(
    "calibdb", deadline=None, derandomize=not THOROUGH, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("calibdb")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if THOROUGH:
        return
    left = [item for item in items if item.get_closest_marker("thorough")]
    config.hook.pytest_deselected(items=left)
    items[:] = [item for item in items if item not in left]
