"""Digests of the inputs of a consensus."""

from dataclasses import fields, replace

import pytest

from calibdb.rules.refit_digests import input_digest, pool_digest
from calibdb.settings import Thresholds


def test_digest_of_the_default_thresholds_is_the_stored_one() -> None:
    """Computed by version 0.1.0: another value would have every stored consensus computed anew."""
    stored_digest = "7d37097fcc75566ccde668aff701711c92295859ea823e73567a290589173bdc"
    assert pool_digest(3, ["a", "b"], Thresholds(), "1.0.0") == stored_digest


@pytest.mark.parametrize("name", [field.name for field in fields(Thresholds)])
def test_digest_differs_by_each_threshold(name: str) -> None:
    changed = replace(Thresholds(), **{name: getattr(Thresholds(), name) + 1})
    assert pool_digest(3, ["a"], changed, "1") != pool_digest(3, ["a"], Thresholds(), "1")


def test_digests_differ_by_method_calibrations_version_and_votes() -> None:
    rules = Thresholds()
    digests = {
        pool_digest(3, ["a"], rules, "1"),
        pool_digest(4, ["a"], rules, "1"),
        pool_digest(3, ["a", "b"], rules, "1"),
        pool_digest(3, ["a"], rules, "2"),
        input_digest("p", []),
        input_digest("p", ["v"]),
        input_digest("q", ["v"]),
    }
    assert len(digests) == 7
