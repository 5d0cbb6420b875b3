"""Rebuild of the answers at the edge from the index, and of the index of their aliases."""

from __future__ import annotations

import time
from collections.abc import Set
from dataclasses import dataclass

from calibdb.lookup.edge_content import Name, object_of
from calibdb.lookup.publication import Publication
from calibdb.store import aws
from calibdb.store.aliases import ALIAS_PREFIX
from calibdb.store.keys import ANSWERS, camera_pk
from infra.ops.context import OpsContext


@dataclass(frozen=True)
class EdgeResult:
    """Numbers of objects that lie at the edge afterwards, and of those that no alias accounts for."""

    objects: int = 0
    orphans: int = 0


def rebuild(context: OpsContext, borne: Set[Name], *, forget_pending: bool = False) -> EdgeResult:
    """Make the objects exactly those that lookups would answer with, whatever was written of them before.

    Parameters
    ----------
    context
        The deployment.
    borne
        Labels and platforms of all calibrations in the bucket; aliases that no calibration bears any more go.
    forget_pending
        Whether to forget who asked by aliases that are not confirmed.
    """
    answers = context.store.edge_answers
    if answers.bucket is None:
        context.echo("WEB_BUCKET_NAME is not set: the answers at the edge stay as they are")
        return EdgeResult()
    # First: what is written from here on has been written down before it is.
    listed = _list_objects(context, answers.bucket)
    me = f"ops-{context.random_hex(8)}"
    publication = Publication(context.store, context.settings, time.time, me)
    expected: set[str] = set()
    for camera_key in _camera_keys(context):
        publication.rebuild(camera_key, listed, borne, forget_pending=forget_pending)
        for alias in context.store.aliases.of(camera_key):
            expected |= {object_of(alias.name, mode) for mode in alias.objects}
    orphans = sorted(listed.keys() - expected)
    answers.delete(orphans)
    return EdgeResult(len(expected), len(orphans))


def _list_objects(context: OpsContext, bucket: str) -> dict[str, str]:
    """List the objects in the bucket with their ETags."""
    with aws.available():
        pages = (
            aws.s3(context.settings.region)
            .get_paginator("list_objects_v2")
            .paginate(Bucket=bucket, Prefix=ANSWERS)
        )
        return {o["Key"]: o["ETag"].strip('"') for page in pages for o in page.get("Contents", [])}


def _camera_keys(context: OpsContext) -> list[str]:
    """List the cameras that have aliases."""
    found = {pk for pk, sk in context.index.keys("CAMERA#") if sk.startswith(ALIAS_PREFIX)}
    return sorted(pk.removeprefix(camera_pk("")) for pk in found)
