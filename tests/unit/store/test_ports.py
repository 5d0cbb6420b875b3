"""Conformance of the ports' implementations: SQLite, and AWS by moto or (`make verify`) ministack."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from calibdb.store import Objects, Table
from calibdb.store.ports import (
    IF_NOT_EXISTS,
    Condition,
    Item,
    compared,
    equals,
)

ADAPTERS = ["aws"] if "CONFORMANCE_ENDPOINT" in os.environ else ["sqlite", "aws"]
pytestmark = pytest.mark.parametrize("adapter", ADAPTERS, indirect=True)
ITEM: Item = {"pk": "P#1", "sk": "S#1", "name": "Kamera é 📷", "count": 7, "list": ["b", "a"], "empty": []}


def test_item_is_returned_as_it_was_put(table: Table) -> None:
    assert table.get("P#1", "S#1") is None
    assert table.put(ITEM) is True
    assert table.get("P#1", "S#1") == ITEM
    assert table.get("P#1", "S#1", consistent=False) == ITEM
    assert table.get("P#1", "S#") is None
    changed: Item = {"pk": "P#1", "sk": "S#1", "count": -3}
    table.put(changed)
    assert table.get("P#1", "S#1") == changed


@pytest.mark.parametrize(
    ("condition", "without_item", "with_item"),
    [
        (IF_NOT_EXISTS, True, False),
        (equals(pk="P#1"), False, True),
        (compared("withdrawn", "absent"), True, True),
        (compared("count", "absent"), True, False),
        (equals(count=7), False, True),
        (equals(count=8), False, False),
        (equals(count="7"), False, False),
        (equals(count=7, name="other"), False, False),
        (equals(withdrawn=7), False, False),
        (compared("count", "<", 7), False, False),
        (compared("count", "<", 8), False, True),
        (compared("count", "<=", 7), False, True),
        (compared("withdrawn", "<=", 7), False, False),
        (IF_NOT_EXISTS | equals(name="other") | compared("count", "<", 8), True, True),
        (equals(name="other") | equals(count=8), False, False),
    ],
)
def test_write_obeys_its_condition(
    table: Table, condition: Condition, without_item: bool, with_item: bool
) -> None:
    fresh: Item = {"pk": "P#2", "sk": "S", "count": 1}
    assert table.put(fresh, condition) is without_item
    assert table.get("P#2", "S") == (fresh if without_item else None)
    table.put(ITEM)
    replaced = {**ITEM, "new": 1}
    assert table.put(replaced, condition) is with_item
    assert table.get("P#1", "S#1") == (replaced if with_item else ITEM)
    table.put(ITEM)
    assert table.put_transaction([replaced, {"pk": "P#3", "sk": "S"}], condition) is with_item
    assert (table.get("P#3", "S") is not None) is with_item
    table.put(ITEM)
    assert table.delete("P#1", "S#1", condition) is with_item
    assert (table.get("P#1", "S#1") is None) is with_item


def test_counter_stops_at_its_limit(table: Table) -> None:
    assert table.add("P", "S", "n", 2, limit=5) == 2
    assert table.add("P", "S", "n", 3, limit=5, ttl=2_000_000_000) == 5
    assert table.add("P", "S", "n", 1, limit=5) is None
    assert table.add("P", "S", "m", 9, limit=5) is None
    assert table.add("P", "S", "m", 4) == 4
    assert table.get("P", "S") == {"pk": "P", "sk": "S", "n": 5, "m": 4, "ttl": 2_000_000_000}


def test_attribute_and_item_are_removed(table: Table) -> None:
    table.remove("P#1", "S#1", "count")
    assert table.get("P#1", "S#1") is None
    table.put(ITEM)
    table.remove("P#1", "S#1", "count")
    table.remove("P#1", "S#1", "count")
    assert table.get("P#1", "S#1") == {name: value for name, value in ITEM.items() if name != "count"}
    assert table.delete("P#1", "S#1") is True
    assert table.delete("P#1", "S#1") is True
    assert table.get("P#1", "S#1") is None


def test_query_returns_a_range_in_the_order_of_utf_8(table: Table) -> None:
    names = ["A#1", "B#!", "B#1", "B#10", "B#2", "B#a", "B#é", "B#ﬀ", "B#📷", "C#1"]
    for name in reversed(names):
        table.put({"pk": "P", "sk": name})
    table.put({"pk": "P2", "sk": "B#1"})

    def keys(items: list[Item]) -> list[object]:
        return [item["sk"] for item in items]

    assert keys(table.query("P", "B#")) == names[1:9]
    assert keys(table.query("P", "B#1")) == ["B#1", "B#10"]
    assert keys(table.query("P", "B#", newest_first=True, limit=3, consistent=True)) == names[8:5:-1]
    assert keys(table.query("P", "B#", limit=99)) == names[1:9]
    assert keys(table.query("P", "B#", limit=3)) == names[1:4]
    assert keys(table.query("P", "B#", limit=9, after=names[3])) == names[4:9]
    assert sorted(table.keys("P")) == sorted([("P2", "B#1"), *(("P", name) for name in names)])
    assert list(table.keys("P2")) == [("P2", "B#1")]
    assert list(table.keys("Q")) == []


def test_objects_are_created_once_and_replaced_by_version(objects: Objects) -> None:
    assert objects.get("a/1") is None
    assert objects.get_version("a/1") is None
    assert objects.create("a/1", b"one") is True
    assert objects.create("a/1", b"two") is False
    found = objects.get_version("a/1")
    assert found is not None
    content, tag = found
    assert content == b"one" == objects.get("a/1")
    assert objects.replace("a/1", b"three", tag) is True
    assert objects.replace("a/1", b"four", tag) is False
    assert objects.replace("a/none", b"five", tag) is False
    assert objects.get("a/1") == b"three"
    objects.put("a/1", b"six", "application/gzip", "public, max-age=60")
    assert objects.get("a/1") == b"six"
    objects.delete(["a/1", "a/none"])
    assert objects.get("a/1") is None


def test_names_are_listed_in_order(objects: Objects) -> None:
    for name in ("b/2", "a/1", "b/10", "b/1", "b", "c"):
        objects.create(name, b"")
    assert list(objects.names("b/")) == ["b/1", "b/10", "b/2"]
    assert list(objects.names("b/", "b/1")) == ["b/10", "b/2"]
    assert list(objects.names("")) == ["a/1", "b", "b/1", "b/10", "b/2", "c"]
    assert list(objects.names("d")) == []


def test_purged_object_is_gone(objects: Objects) -> None:
    objects.put("a/b", b"1")
    objects.put("a/bc", b"2")
    assert objects.purge_all_versions(["a/b", "a/none"]) == 1
    assert list(objects.names("")) == ["a/bc"]


def at_once(count: int, call: Callable[[int], object]) -> list[object]:
    """Call in as many threads, and return the answers."""
    with ThreadPoolExecutor(count) as threads:
        return list(threads.map(call, range(count)))


def test_of_concurrent_writers_one_wins(table: Table, objects: Objects) -> None:
    assert at_once(6, lambda n: table.put({"pk": "P", "sk": "S", "n": n}, IF_NOT_EXISTS)).count(True) == 1
    assert at_once(6, lambda n: objects.create("name", str(n).encode())).count(True) == 1
    assert sorted(map(str, at_once(8, lambda _: table.add("P", "N", "n", 1, limit=5)))) == [
        *map(str, range(1, 6)),
        *["None"] * 3,
    ]
