"""The smoke test's capture on a deployment, and its removal."""

from infra.deploy import smoke, smoke_capture
from tests.aws.emulator import LocalStack
from tests.helpers.service.client import TOKEN, Client
from tests.helpers.service.published import store


def test_one_capture_is_made_shown_and_removed() -> None:
    removed: list[str] = []

    def remove(identity: str) -> None:
        assert store(stack).calibrations.get(identity) is not None
        removed.append(identity)
        stack.wait_until_idle(60)
        made = {
            "TableName": stack.environment["TABLE_NAME"],
            "KeypointBucketName": stack.environment["BUCKET_NAME"],
        }
        smoke_capture.remove(made, "us-east-1", "RefitFunction", identity)

    with LocalStack() as stack:
        with stack.serve() as address:
            assert list(smoke_capture.problems(smoke.Site(address), TOKEN, remove)) == []
        (identity,) = removed
        stack.wait_until_idle(60)
        assert store(stack).calibrations.get(identity) is None
        key = identity.rpartition("-")[0]
        assert store(stack).calibrations.modes(key) == []
        assert store(stack).consensuses.of(key) == []
        cameras = Client(stack).call("GET", "/v1/cameras", token=TOKEN, query="query=smoke").json["cameras"]
        assert cameras == []
