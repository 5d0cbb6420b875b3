"""Operators' tools know rigs."""

import json
from pathlib import Path

import pytest

from calibdb.access.tokens import contributor
from infra.ops import reindex, restore, withdrawal
from infra.ops.context import OpsContext
from infra.ops.dump import dump
from infra.server.server import Server
from tests.helpers.service import strangers
from tests.helpers.service.client import EDGE
from tests.helpers.service.intercepted import crash_after
from tests.helpers.service.rigs import RigTruth

ENVIRONMENT = {"EDGE_SECRETS": EDGE}
JOBS = False
HERE, THERE = "192.0.2.10", "192.0.2.11"


@pytest.fixture(scope="module")
def context(stack: Server) -> OpsContext:
    return strangers.context(stack)


def names(stack: Server, *prefixes: str) -> set[str]:
    return {name for name in stack.storage.objects.names("") if name.startswith(prefixes)}


def two_places(stack: Server, moments: int = 4) -> RigTruth:
    rig = RigTruth(stack, seed=3, address=HERE)
    rig.clients[1].address = THERE
    rig.open()
    for number in range(moments):
        rig.moment(f"m{number}")
    return rig


@pytest.fixture(scope="module")
def unpublished(stack: Server) -> RigTruth:
    rig = two_places(stack)
    rig.state()
    with crash_after(stack.storage, 2):  # the rig's object and item
        assert rig.call("POST", "/finish").status == 503
    return rig


def test_reindex_completes_a_rig_that_ended_and_mends_the_index(
    stack: Server, context: OpsContext, unpublished: RigTruth, tmp_path: Path
) -> None:
    rig, running = unpublished, two_places(stack, moments=1)
    state = rig.state()
    assert state["status"] == "finished"
    assert names(stack, "rig_calibrations/", "calibrations/") == set()
    context.remove_items(key for pk in ("RIG#", "SESSION#") for key in context.storage.table.keys(pk))
    done = reindex.reindex(context)
    assert (done.rigs, done.sessions, done.published) == (2, 4, 2)
    assert names(stack, "rig_calibrations/") == {f"rig_calibrations/{rig.rig_id}.json"}
    assert rig.state() == state
    for calibration in state["result"]["cameras"]:
        assert rig.clients[0].calibration(calibration).status == 200
    assert running.call("POST", "/moments", {"moment": "goes-on"}).status == 201
    assert reindex.reindex(context).published == 0
    # what a dump holds
    dump(context, tmp_path / "private", private=True)
    (line,) = (tmp_path / "private" / restore.RIGS).read_text().splitlines()
    assert json.loads(line)["state"]["result"] == state["result"]
    assert contributor(context.settings.contributor_secret, HERE, "dev") not in line
    dump(context, tmp_path / "public")
    assert not (tmp_path / "public" / restore.RIGS).exists()
    context.objects.purge_all_versions([f"rig_calibrations/{rig.rig_id}.json"])
    restore.load(context, tmp_path / "private")
    assert names(stack, "rig_calibrations/") == {f"rig_calibrations/{rig.rig_id}.json"}


def test_forgetting_a_contributor_takes_their_rigs(stack: Server, context: OpsContext) -> None:
    finished, running = two_places(stack), two_places(stack, moments=1)
    result = finished.call("POST", "/finish").json["result"]
    gone = contributor(context.settings.contributor_secret, THERE, "dev")
    counted = withdrawal.forget(context, {gone}, dry_run=True)
    done = withdrawal.forget(context, {gone})
    assert done == counted
    assert done.rigs >= 3, "finished in two places, and running"
    left = names(stack, "rigs/", "rig_calibrations/")
    for rig in (finished, running):
        assert not [name for name in left if rig.rig_id in name]
        assert rig.call("GET").status == 404
    own, others = result["cameras"]
    client = finished.clients[0]
    assert client.calibration(own).status == 200, "of another client"
    assert client.calibration(others).status == 404
    assert gone not in withdrawal._contributors(context)
