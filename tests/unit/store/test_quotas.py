"""Counters of use, split where a plan is large, and trial tokens that nothing used."""

import itertools
from dataclasses import replace

import pytest

from calibdb.access.tokens import ApiToken
from calibdb.errors import UnavailableError
from calibdb.store import Objects, Table, Tokens
from calibdb.store.quotas import MIN_SHARDED_LIMIT, SHARDS, Quotas

NOW = 1_700_000_000


def test_large_counter_is_split_and_stops_exactly_at_its_limit(
    table: Table, monkeypatch: pytest.MonkeyPatch
) -> None:
    limit = MIN_SHARDED_LIMIT + 5
    starts = itertools.count()
    monkeypatch.setattr("calibdb.store.quotas.randrange", lambda shards: next(starts) % shards)
    quotas = Quotas(table)
    parts = [limit // SHARDS + (shard < limit % SHARDS) for shard in range(SHARDS)]
    assert sum(parts) == limit
    for shard, part in enumerate(parts):  # all but three of the limit have been used
        pk = f"TOKEN#t#{shard}" if shard else "TOKEN#t"
        table.add(pk, "QUOTA#2023-11-14T22", "views", part - (shard in (0, 3, 6)))
    assert quotas.used("t", NOW)["views"] == limit - 3
    estimates = [quotas.take("t", "views", NOW, limit) for _ in range(5)]
    assert estimates[3:] == [None, None]
    assert all(estimate and 0 < estimate <= limit for estimate in estimates[:3])
    assert quotas.used("t", NOW)["views"] == limit
    assert quotas.use("t", NOW) == {"2023-11-14T22": {"views": limit}}


def test_calls_of_a_large_plan_spread_over_the_keys(table: Table) -> None:
    quotas = Quotas(table)
    for n in range(120):
        assert quotas.take("t", "views", NOW, MIN_SHARDED_LIMIT)
        assert quotas.take("t", "views", NOW, 400, f"{n:012x}") == 1
    assert quotas.used("t", NOW) == {"views": 120}
    for name in ("QUOTA#", "SHARE#"):
        counts = [
            sum(item["views"] for item in table.query(pk, name))
            for pk in ("TOKEN#t", *(f"TOKEN#t#{shard}" for shard in range(1, SHARDS)))
        ]
        assert sum(counts) == 120
        assert max(counts) < 120 * 0.3, name


def test_trial_tokens_that_expired_unused_are_orphans(table: Table, objects: Objects) -> None:
    tokens = Tokens(table, objects)
    trial = ApiToken("unused", "0" * 64, (), "trial", NOW, expires=NOW)
    for token in (trial, replace(trial, id="used"), replace(trial, id="young", expires=NOW + 8 * 86_400)):
        tokens.create(token)
    tokens.create(replace(trial, id="page", expires=None))
    tokens.keep("used")
    assert tokens.orphans(NOW + 6 * 86_400) == []
    later = NOW + 8 * 86_400
    assert tokens.orphans(later) == ["unused"]
    table.delete("TOKEN#unused", "META")  # as DynamoDB removes what expired
    assert tokens.orphans(later) == ["unused"]
    assert tokens.remove(["unused"]) == 1
    assert sorted(tokens.ids()) == ["page", "used", "young"]
    assert tokens.orphans(later) == []
    table.delete("TOKEN#page", "META")  # the index was lost, and with it what was used
    with pytest.raises(UnavailableError, match="run `reindex` first"):
        tokens.orphans(later)
