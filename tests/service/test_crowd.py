"""What a lookup costs does not depend on how many other cameras there are."""

from infra.local import LocalStack
from tests.bench.bench_lookup import cpu, one_known
from tests.crowd import crowd


def test_other_cameras_do_not_slow_a_lookup(stack: LocalStack) -> None:
    """Twenty thousand of them here; `make bench ONLY=lookup` has a hundred thousand."""
    lookup = one_known(stack)
    before = min(cpu(lookup) for _ in range(3))
    crowd(stack, 20_000)
    assert min(cpu(lookup) for _ in range(3)) < 1.2 * before
