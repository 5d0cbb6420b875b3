"""The index of calibrations made anew from the bucket, which is the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import boto3

from calibdb.schema import DISTORTION_MODELS, CalibrationDocument, RefitRequest
from calibdb.store import Store
from calibdb.store.keys import calibrations_prefix, camera_pk


@dataclass(frozen=True)
class Report:
    """What was done."""

    calibrations: int
    consensuses: int
    removed: int


@dataclass(frozen=True)
class _Group:
    """What one consensus rests on: one camera at one size and zoom."""

    camera_key: str
    img_size: tuple[int, int]
    zoom: float


def reindex(store: Store, table_name: str, say: Callable[[str], None]) -> Report:
    """Let the index name exactly what is in the bucket, and recompute every consensus.

    Safe to run on a table in use, and again: lookups go on, with the old answers until the new ones are
    there. What is published while it runs is indexed by its own submit.

    Parameters
    ----------
    store
        The storage.
    table_name
        Its table.
    say
        Told about each camera as it is done.
    """
    # First, so that what is published from here on cannot be mistaken for something that the bucket lacks.
    indexed = set(_keys(table_name))
    named: set[tuple[str, str]] = set()
    groups: dict[_Group, int] = {}
    for document in store.calibrations.all():
        store.calibrations.index(document)
        named.add(_key(document))
        group = _Group(document.camera_key, document.img_size, document.zoom)
        groups[group] = groups.get(group, 0) + 1
    stale = {key for key in indexed if key[1].startswith("CALIBRATION#") and key not in named}
    # A consensus that counted what is gone would never give way to one that counts less.
    cameras = {pk for pk, _ in stale}
    stale |= {key for key in indexed if key[1].startswith("CONSENSUS#") and key[0] in cameras}
    _remove(table_name, stale)
    consensuses = 0
    for group, count in groups.items():
        request = RefitRequest(
            camera=group.camera_key, img_size=group.img_size, zoom=group.zoom, models=DISTORTION_MODELS
        )
        answer = store.refit.now(request)
        consensuses += sum(1 for consensus in answer.models.values() if consensus is not None)
        say(f"{group.camera_key} {group.img_size[0]}x{group.img_size[1]}: {count} calibrations")
    return Report(sum(groups.values()), consensuses, len(stale))


def _key(document: CalibrationDocument) -> tuple[str, str]:
    prefix = calibrations_prefix(document.img_size, document.zoom)
    return camera_pk(document.camera_key), f"{prefix}{document.id}"


def _keys(table_name: str) -> Iterator[tuple[str, str]]:
    pages = (
        boto3.client("dynamodb")
        .get_paginator("scan")
        .paginate(
            TableName=table_name,
            FilterExpression="begins_with(pk, :cameras)",
            ExpressionAttributeValues={":cameras": {"S": "CAMERA#"}},
            ProjectionExpression="pk, sk",
        )
    )
    for page in pages:
        for item in page["Items"]:
            yield item["pk"]["S"], item["sk"]["S"]


def _remove(table_name: str, keys: set[tuple[str, str]]) -> None:
    client = boto3.client("dynamodb")
    for pk, sk in sorted(keys):
        client.delete_item(TableName=table_name, Key={"pk": {"S": pk}, "sk": {"S": sk}})
