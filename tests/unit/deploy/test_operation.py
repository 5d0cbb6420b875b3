"""Operation of a deployment: replica, contact, probe, alarms, clean checkouts."""

import re
from datetime import UTC, datetime
from pathlib import Path

import pytest
from botocore.exceptions import ClientError

from calibdb.store.aws import available
from infra.deploy import __main__ as command
from infra.deploy.site import uploads
from infra.deploy.steps import Target, steps
from infra.deploy.template import parse
from infra.release.checkout import CheckoutError
from tests.helpers.data import ROOT
from tests.helpers.sam import resources

NOW = datetime(2026, 11, 22, tzinfo=UTC)


def test_bucket_of_the_replica_is_there_before_the_stack_names_it() -> None:
    told = list(steps(Target("calibdb", "us-east-1", {"ReplicaRegion": "eu-west-1"})))
    texts = [step.text for step in told]
    made = texts.index("make the bucket for the replica in eu-west-1")
    assert made < texts.index("create or change the stack")
    region = told[made].command[told[made].command.index("--region") + 1]
    assert region == "eu-west-1"
    # Both templates build the name in the same way.
    replica = parse(ROOT / "infra/deploy/replica.yaml")["Resources"]["ReplicaBucket"]["Properties"]
    name = replica["BucketName"]["Fn::Sub"].replace("${Stack}", "${AWS::StackName}")
    bucket = resources()["KeypointBucket"]["Properties"]
    condition, replication, _ = bucket["ReplicationConfiguration"]["Fn::If"]
    assert condition == "Replicate"
    named = {rule["Destination"]["Bucket"]["Fn::Sub"] for rule in replication["Rules"]}
    expected = name.replace("${AWS::Region}", "${ReplicaRegion}")
    assert named == {f"arn:${{AWS::Partition}}:s3:::{expected}"}
    assert len({rule["Priority"] for rule in replication["Rules"]}) == len(replication["Rules"])
    # The role may write there and nowhere else, and remove nothing.
    policy = resources()["ReplicationPolicy"]["Properties"]["PolicyDocument"]["Statement"]
    (writes,) = (s for s in policy if s["Sid"] == "WriteReplica")
    assert writes["Resource"]["Fn::Sub"] == f"arn:${{AWS::Partition}}:s3:::{expected}/*"
    assert not [s for s in policy if any("Delete" in action for action in s["Action"])]


def test_replica_outlives_its_stack_and_is_closed() -> None:
    resources = parse(ROOT / "infra/deploy/replica.yaml")["Resources"]
    bucket = resources["ReplicaBucket"]
    assert bucket["UpdateReplacePolicy"] == "Retain"
    assert bucket["DeletionPolicy"] == "RetainExceptOnCreate"
    assert bucket["Properties"]["VersioningConfiguration"] == {"Status": "Enabled"}
    assert all(bucket["Properties"]["PublicAccessBlockConfiguration"].values())
    (denied,) = resources["ReplicaBucketPolicy"]["Properties"]["PolicyDocument"]["Statement"]
    assert (denied["Effect"], denied["Condition"]) == ("Deny", {"Bool": {"aws:SecureTransport": "false"}})


def test_contact_is_published_where_one_is_named(tmp_path: Path) -> None:
    (tmp_path / "index.html").touch()
    named = {u.key: u.content for u in uploads(tmp_path, {}, "mailto:security@site.example", NOW)}
    assert named[".well-known/security.txt"].startswith(b"Contact: mailto:security@site.example\n")
    assert ".well-known/security.txt" not in {u.key for u in uploads(tmp_path, {}, None, NOW)}


def test_every_alarm_is_explained() -> None:
    alarms = {n for n, r in resources().items() if r["Type"] == "AWS::CloudWatch::Alarm"}
    explained = set(re.findall(r"^\| `(\w+Alarm)`", (ROOT / "docs/operations.md").read_text(), re.MULTILINE))
    assert explained == alarms


def test_changed_checkout_is_deployed_only_by_wish(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse() -> None:
        raise CheckoutError("new.py differs")

    monkeypatch.setattr(command, "check_clean", refuse)
    deployed: list[Target] = []
    monkeypatch.setattr(command, "deploy", deployed.append)
    assert command.main(["--stack", "calibdb"]) == 1
    assert "new.py differs, or deploy with --dirty" in capsys.readouterr().err
    assert not deployed
    assert command.main(["--stack", "calibdb", "--dirty"]) == 0
    assert len(deployed) == 1


def test_storage_that_refuses_a_call_ends_the_deployment_with_the_reason_of_aws(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(_: Target) -> None:
        with available():
            raise ClientError({"Error": {"Code": "AccessDenied"}}, "DeleteObjects")

    monkeypatch.setattr(command, "deploy", refuse)
    assert command.main(["--dirty"]) == 1
    assert "DeleteObjects" in capsys.readouterr().err
