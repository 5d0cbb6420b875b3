"""The replica of the keypoint bucket: a stack is made of it again, and what was forgotten is not in it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import boto3
import pytest

from calibdb.errors import UnavailableError
from infra.deploy.template import parse
from infra.ops.__main__ import main
from infra.ops.replica import ReplicatedObjects
from infra.server.server import Server
from tests.helpers.aws import account
from tests.helpers.data import ROOT
from tests.helpers.service.client import Client
from tests.helpers.service.published import asked, calibration, mode_of, store

HERE, THERE = "us-east-1", "eu-west-1"


def replicated_prefixes() -> set[str]:
    """Prefixes that the template replicates."""
    bucket = parse(ROOT / "template.yaml")["Resources"]["KeypointBucket"]["Properties"]
    _, replication, _ = bucket["ReplicationConfiguration"]["Fn::If"]
    return {rule["Filter"]["Prefix"] for rule in replication["Rules"]}


def test_stack_is_restored_from_the_replica_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`aws s3 sync` and `reindex`; a copy of the same prefixes plays the part of S3's replication."""
    documents = [calibration("Replicated 77", n) for n in range(6)]
    question = {"camera": "Replicated 77", "redirect": False}
    with Server(tmp_path / "lost") as stack:
        for document in documents:
            store(stack).calibrations.publish(document)
        store(stack).refit.now(asked(mode_of(documents[0]), "rectilinear"))
        store(stack).calibrations.withdraw(documents[5], "wrong", 1)
        store(stack).refit.now(asked(mode_of(documents[0]), "rectilinear"))
        before = Client(stack).lookup(**question)
        assert before.status == 200
        files = stack.storage.objects
        replica = {
            name: files.get(name) or b""
            for name in files.names("")
            if name.startswith(tuple(replicated_prefixes()))
        }
    # Sessions last for two days; every other folder that a module of the store writes is in the replica.
    assert replicated_prefixes() == {"calibrations/", "rig_calibrations/", "votes/", "tokens/", "priors/"}
    with Server(tmp_path / "restored") as stack:
        for name, content in replica.items():
            stack.storage.objects.put(name, content)
    monkeypatch.setenv("DATA_DIR", str(tmp_path / "restored"))
    assert main(["reindex"]) == 0
    with Server(tmp_path / "restored") as stack:
        after = Client(stack).lookup(**question)
        assert (after.status, after.json) == (before.status, before.json)
        (consensus, *_) = store(stack).consensuses.at(mode_of(documents[0]))
        assert consensus.total == 5  # the withdrawn one stays withdrawn


@pytest.fixture
def replicated() -> Iterator[tuple[Any, Any]]:
    """Buckets in two regions, as template.yaml and replica.yaml make them; moto copies nothing."""
    with account():
        here, there = (boto3.client("s3", region_name=region) for region in (HERE, THERE))
        here.create_bucket(Bucket="keypoints")
        there.create_bucket(Bucket="replica", CreateBucketConfiguration={"LocationConstraint": THERE})
        for client, bucket in ((here, "keypoints"), (there, "replica")):
            client.put_bucket_versioning(Bucket=bucket, VersioningConfiguration={"Status": "Enabled"})
            for content in (b"first", b"second"):
                client.put_object(Bucket=bucket, Key="calibrations/a/1.json", Body=content)
            client.put_object(Bucket=bucket, Key="calibrations/a/2.json", Body=b"stays")
        yield here, there


def replicate(here: Any) -> None:
    rule = {
        "ID": "calibrations",
        "Priority": 1,
        "Status": "Enabled",
        "Filter": {"Prefix": "calibrations/"},
        "Destination": {"Bucket": "arn:aws:s3:::replica"},
    }
    role = "arn:aws:iam::123456789012:role/replication"
    here.put_bucket_replication(Bucket="keypoints", ReplicationConfiguration={"Role": role, "Rules": [rule]})


def versions(client: Any, bucket: str) -> dict[str, int]:
    found: dict[str, int] = {}
    for version in client.list_object_versions(Bucket=bucket).get("Versions", []):
        found[version["Key"]] = found.get(version["Key"], 0) + 1
    return found


def test_purged_object_is_gone_from_the_replica_in_every_version(replicated: tuple[Any, Any]) -> None:
    here, there = replicated
    replicate(here)
    objects = ReplicatedObjects("keypoints", HERE, {HERE: here, THERE: there}.__getitem__)
    assert objects.purge_all_versions(["calibrations/a/1.json"]) == 2
    assert versions(here, "keypoints") == versions(there, "replica") == {"calibrations/a/2.json": 1}


def test_bucket_without_replica_is_purged_alone(replicated: tuple[Any, Any]) -> None:
    here, there = replicated
    objects = ReplicatedObjects("keypoints", HERE, {HERE: here}.__getitem__)
    assert objects.replica is None
    assert objects.purge_all_versions(["calibrations/a/1.json"]) == 2
    assert versions(there, "replica")["calibrations/a/1.json"] == 2


def test_replica_that_cannot_be_reached_stops_the_purge(replicated: tuple[Any, Any]) -> None:
    """Otherwise a copy would remain of which nothing tells any more."""
    here, _ = replicated
    replicate(here)
    broken = boto3.client("s3", region_name=THERE, aws_access_key_id="none", aws_secret_access_key="none")

    def fail(**_: Any) -> None:
        raise UnavailableError("Storage did not answer.")

    broken.meta.events.register("before-call.s3.*", fail)
    objects = ReplicatedObjects("keypoints", HERE, {HERE: here, THERE: broken}.__getitem__)
    with pytest.raises(UnavailableError):
        objects.purge_all_versions(["calibrations/a/1.json"])
    assert versions(here, "keypoints")["calibrations/a/1.json"] == 2
