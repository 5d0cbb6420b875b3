"""Every role grants what its function asks of AWS, and nothing that it never asks for.

moto lets everybody do everything. So the calls are recorded on their way out, by the function that makes
them, and held against the template's statements.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

import boto3
import pytest

from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.store.aws import DynamoTable
from calibdb.store.ports import Condition, Item
from tests.aws.emulator import LocalStack
from tests.helpers.clock import Clock
from tests.helpers.service.client import CAMERA, Client, Truth
from tests.helpers.service.iam import Grant, Needed, grants, needs_of_machine, recording, running
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, store, views
from tests.helpers.service.rigs import RigTruth
from tests.helpers.service.strangers import make, manage, rotate, states

TABLE = "arn:aws:dynamodb:us-east-1:123456789012:table/calibdb-table"
BUCKET = "arn:aws:s3:::calibdb-keypointbucket"
Recorded = Mapping[str, set[Needed]]  # by function
TOKEN = "cdb_page_secret"  # of a plan with limits, so that use is counted
#: granted and not asked for in a local stack, and why it is granted nevertheless
UNASKED = {
    "ssm:GetParameters": "secrets are in the environment here",
    "s3:ListBucket": "tells a missing object from a denied one, where S3 does not",
}


@pytest.fixture(scope="module")
def recorded() -> Iterator[Recorded]:
    clock = Clock(time.time())
    # On AWS each function remembers tokens for itself; here they would share one memory.
    instances: dict[tuple[str | None, Settings], Service] = {}

    def of(settings: Settings) -> Service:
        key = (running.get(), settings)
        if key not in instances:
            instances[key] = Service.build(settings, Store.of(settings), clock)
        return instances[key]

    environment = {"CONTRIBUTOR_PERIOD": "86400", "MIN_CALIBRATIONS": "2"}
    with LocalStack(environment) as stack, Service.override(of):
        for token_id in ("page", "other"):
            token = ApiToken(token_id, secret_hash("secret"), plan="page")
            store(stack).tokens.create(token)
        known = [calibration("Well known", n) for n in range(3)]
        mode = mode_of(known[0])
        rectilinear = asked(mode, "rectilinear").model_dump(mode="json")
        for document in known[:2]:
            store(stack).calibrations.publish(document)
        with recording() as needed:
            stack.functions["RefitFunction"](rectilinear)
            use(stack)
            rig = capture_rig(stack)
            manage_tokens(stack)
            clock.now += 700  # what was counted in memory is written down
            use_again(stack)
            assert Client(stack).call("GET", f"/v1/rigs/{rig}/result", token=TOKEN).status == 200
            stack.wait_until_idle(60)
            assert stack.functions["DumpFunction"]({})["name"] is not None
            assert stack.functions["DumpFunction"]({})["name"] is None
            objects = boto3.client("s3").list_objects_v2(
                Bucket=stack.environment["BUCKET_NAME"], Prefix="calibrations/"
            )["Contents"]
            items = [{"Key": o["Key"].replace("c4-", "c1-"), "Size": 1} for o in objects[:2]]
            stack.functions["BackfillFunction"]({"Items": [*items, {"Key": objects[0]["Key"], "Size": 1}]})
            stack.functions["RefitFunction"]({**asked(mode).model_dump(mode="json"), "queued": True})
            stack.wait_until_idle(60)
            # The answers at the edge change, and go.
            store(stack).calibrations.publish(known[2])
            stack.functions["RefitFunction"](rectilinear)
            for document in known:
                store(stack).calibrations.withdraw(document, "wrong", 0)
            stack.functions["RefitFunction"](asked(mode).model_dump(mode="json"))
        yield dict(needed)


def use(stack: LocalStack) -> None:
    """A capture with an undone view, one that is forgotten, and every way of reading."""
    client = Client(stack, api_token=TOKEN)
    assert client.open(camera="Well known", platform=PLATFORM).status == 201
    truth = Truth(seed=3)
    with overtaken():
        pose = client.pose().json
    with overtaken():
        assert client.view(pose["index"], *truth.see(pose)).json["accepted"]
    assert client.call("DELETE", f"/v1/session/views/{pose['index']}").status == 200
    assert client.pose("skip=1").status == 200
    assert client.state()["status"] == "capturing"
    assert client.forget().status == 204
    well_known = {**CAMERA, "camera": "Well known", "platform": PLATFORM}
    assert client.call("POST", "/v1/session", well_known).status == 201
    seen = views(Truth(seed=30), 4)
    client.open(camera="Captured here", platform=PLATFORM, capture="recorded")
    assert client.call("POST", "/v1/session/batch", {"index": 0, "views": seen}).status == 200
    state = client.finish().json
    consent = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}
    assert client.call("POST", "/v1/session/licence", consent).status == 200
    stack.wait_until_idle(60)
    assert store(stack).consensuses.of(state["calibration_id"].rpartition("-")[0])
    for query in ("format=gltf", ""):
        assert client.calibration(state["calibration_id"], query).status == 200
    assert client.lookup(camera="Well known", platform=PLATFORM).status == 200
    assert client.lookup(camera="Well known", platform=PLATFORM, distortion_model="rational").status == 200
    assert client.call("GET", "/v1/cameras", token=TOKEN, query="query=known").json["cameras"]
    assert client.lookup(camera="Unknown (046d:0825)", redirect=False).status == 404
    checker = Client(stack, api_token="cdb_other_secret")
    checker.authenticate()
    body = {**well_known, "views": seen[:3]}
    assert checker.call("POST", "/v1/checks", body).json["counted"]
    assert checker.call("POST", "/v1/checks", body).status == 200
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("urllib.request.OpenerDirector.open", lambda *_, **__: 1 / 0)
        assert client.call("GET", "/healthz", token="", query="deep=1").status == 503


@contextmanager
def overtaken(key: str = "SESSION#") -> Iterator[None]:
    """The first write of a session, or of another key, comes too late, as when another request got ahead."""
    put, lost = DynamoTable.put, []

    def put_late(table: DynamoTable, item: Item, condition: Condition | None = None) -> bool:
        if not lost and item["pk"].startswith(key):
            lost.append(item)
            return False
        return put(table, item, condition)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(DynamoTable, "put", put_late)
        yield
    assert lost


def capture_rig(stack: LocalStack) -> str:
    """Capture a rig from its first camera to its files, and forget another; return the id of the first."""
    rig = RigTruth(stack, seed=3, api_token=TOKEN)
    with overtaken("RIG#"):
        rig.open()
    assert rig.clients[0].pose().status == 200, "the first to ask computes the target"
    rig.moment("m0")
    rig.moment("undone", positions=[0])
    assert rig.call("GET", query="skip=1").status == 200
    assert rig.call("DELETE", "/moments/undone").status == 200
    assert rig.call("GET", token=TOKEN).status == 200
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("calibdb.rules.rig_result.MIN_AGREEING_VIEWS", 1)  # four only take longer
        assert rig.call("POST", "/finish").status == 200
    stack.wait_until_idle(60)
    assert rig.result("ros").status == 200
    store(stack).rigs.forget(rig.rig_id, 0)  # as if it had expired
    assert rig.result().json["cameras"]
    forgotten = RigTruth(stack, seed=3, api_token=TOKEN).open()
    assert forgotten.clients[1].call("DELETE", "/v1/session").status == 204
    with overtaken("RIG#"):
        assert forgotten.join(1).status == 201
    assert forgotten.call("DELETE").status == 204
    return rig.rig_id


def manage_tokens(stack: LocalStack) -> None:
    """A token that somebody makes, proves, changes, uses, and revokes."""
    client = Client(stack)
    made = make(client, "https://example.org")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("calibdb.proof.read_proof", lambda _: made["origins"][0]["proof"]["content"])
        assert set(states(manage(client, "POST", made, "/verify")).values()) == {"verified"}
    other = make(client)
    for _ in range(2):
        assert client.call("GET", "/v1/usage", token=other["token"]).json["plan"] == "trial"
    assert manage(client, "PATCH", made, body={"name": "x"}).status == 200
    rotate(client, made)
    assert manage(client, "GET", made).status == 200
    assert manage(client, "DELETE", made).status == 204


def use_again(stack: LocalStack) -> None:
    client = Client(stack, api_token=TOKEN)
    key = calibration("Well known", 0).camera_key
    assert client.lookup(camera="Unknown (046d:0825)", redirect=False).status == 404
    for _ in range(2):
        assert client.lookup(camera="Well known", platform=PLATFORM).status == 200
        assert client.call("GET", "/v1/cameras", token=TOKEN, query="query=known").json["cameras"]
        assert client.call("GET", f"/v1/cameras/{key}", token=TOKEN).json["modes"]
        consensus = client.lookup(camera="Well known", platform=PLATFORM).json["id"]
        assert client.calibration(consensus).status == 200
        client.calibration(consensus.replace("c4-", "c1-", 1))


def refused(asked: set[Needed], given: Sequence[Grant]) -> set[Needed]:
    return {one for one in asked if not any(grant.allows(one) for grant in given)}


def unused(given: Sequence[Grant], asked: set[Needed]) -> set[tuple[str, str]]:
    """Statements and their actions that nothing needs."""
    return {
        (grant.sid, action)
        for grant in given
        for action in grant.actions
        if not any(one.action == action and grant.allows(one) for one in asked)
    }


def test_no_call_without_a_grant(recorded: Recorded) -> None:
    for function, given in grants().items():
        assert refused(recorded[function], given) == set(), function
    assert recorded.keys() == grants().keys()


def test_no_grant_without_a_call(recorded: Recorded) -> None:
    for function, given in grants().items():
        assert {action for _, action in unused(given, recorded[function])} <= UNASKED.keys(), function


def test_every_granted_attribute_is_written(recorded: Recorded) -> None:
    """A function adds to the counters that it counts with, and to no others."""
    for function, given in grants().items():
        for grant in given:
            writes = [one.attributes or () for one in recorded[function] if grant.allows(one)]
            assert grant.attributes <= frozenset().union(*writes), (function, grant.sid)


def test_state_machine_role_grants_what_its_definition_needs() -> None:
    ((name, given),) = grants("AWS::Serverless::StateMachine").items()
    asked = set(needs_of_machine(name))
    assert refused(asked, given) == set()
    assert unused(given, asked) == set()
    others = {
        Needed("s3:ListBucket", BUCKET, prefix="sessions/"),
        Needed("s3:GetObject", f"{BUCKET}/calibrations/x"),
        Needed(
            "lambda:InvokeFunction", "arn:aws:lambda:us-east-1:123456789012:function:calibdb-SubmitFunction"
        ),
        Needed("states:StopExecution", "arn:aws:states:us-east-1:123456789012:execution:calibdb-backfill2:x"),
    }
    assert refused(others, given) == others


def test_lookup_role_cannot_write_calibrations() -> None:
    others = {
        Needed("dynamodb:PutItem", TABLE, frozenset({"TOKEN#x"})),
        Needed("dynamodb:Scan", TABLE),
        Needed("s3:GetObject", f"{BUCKET}/calibrations/x"),
        Needed("s3:DeleteObject", f"{BUCKET}/sessions/x"),
    }
    assert refused(others, grants()["LookupFunction"]) == others


def test_statement_allows_only_its_named_calls() -> None:
    grant = Grant(
        "S",
        ("dynamodb:UpdateItem",),
        ("arn:t",),
        {
            "ForAllValues:StringLike": {"dynamodb:LeadingKeys": ["A#*"]},
            "ForAllValues:StringEquals": {"dynamodb:Attributes": ["pk", "n"]},
            "StringEqualsIfExists": {"dynamodb:ReturnValues": ["NONE"]},
        },
    )
    fine = Needed("dynamodb:UpdateItem", "arn:t", frozenset({"A#1"}), frozenset({"pk", "n"}))
    assert grant.allows(fine)
    for change in (
        {"resource": "arn:u"},
        {"keys": frozenset({"B#1"})},
        {"attributes": frozenset({"pk", "secret"})},
        {"returned": "ALL_OLD"},
    ):
        assert not grant.allows(replace(fine, **change))
