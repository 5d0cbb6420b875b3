"""Published versions of the SDK: what never changes, its hashes, and what a deployment does with it."""

import io
import json
import tarfile
from dataclasses import replace
from pathlib import Path

import boto3
import pytest

from calibdb import __version__
from infra.deploy import aws
from infra.deploy.site import Upload
from infra.release.changelog import is_released
from infra.web_build import sdk
from infra.web_build.sdk import ROOT, sdk_files, sdk_version
from infra.web_build.site_headers import headers
from tests.helpers.aws import account

WEB = ROOT / "web"
VERSION = sdk_version(WEB)


def test_every_module_of_the_version_has_the_hash_that_is_published() -> None:
    files = sdk_files(WEB)
    facts = json.loads(files[f"sdk/{VERSION}/integrity.json"])
    assert facts["version"] == VERSION
    assert len(facts["files"]) > 15
    for name, found in facts["files"].items():
        assert found == sdk.sri(files[f"sdk/{VERSION}/{name}"]), name
    assert files["sdk/integrity.json"] == files[f"sdk/{VERSION}/integrity.json"]
    assert "immutable" in headers(f"sdk/{VERSION}/calibdb.js")["cache-control"]
    assert headers("sdk/integrity.json")["cache-control"] == "no-cache", "it moves with each deployment"
    (moved,) = [
        name for name in facts["files"] if files[f"sdk/{VERSION}/{name}"] != (WEB / "sdk" / name).read_bytes()
    ]
    assert moved == "request.js", "which says where the API is, from its own folder"


def test_import_map_names_all_that_the_package_exports() -> None:
    names = json.loads(sdk.import_map(WEB, "https://site.example"))
    at = f"https://site.example/sdk/{VERSION}"
    assert names["imports"]["calibdb"] == f"{at}/calibdb.js"
    assert names["imports"]["calibdb/adapters/three"] == f"{at}/adapters/three.js"
    exports = json.loads((WEB / "sdk/package.json").read_text())["exports"]
    plain = {f"calibdb{name[1:]}" for name in exports if "*" not in name}
    assert plain <= set(names["imports"])
    assert set(names["imports"].values()) <= set(names["integrity"])


def test_package_has_modules_types_licence_and_the_projects_version() -> None:
    with tarfile.open(fileobj=io.BytesIO(sdk_files(WEB)[f"sdk/{VERSION}/calibdb.tgz"])) as archive:
        names = set(archive.getnames())
        described = json.load(archive.extractfile("package/package.json") or io.BytesIO())
    assert {
        "package/calibdb.js",
        "package/types/calibdb.d.ts",
        "package/LICENSE",
        "package/README.md",
    } <= names
    assert described["version"] == VERSION
    assert VERSION.startswith(__version__)


def test_whatever_is_no_release_has_a_version_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    released = "# Changelog\n\n## Unreleased\n\n## 0.1.0 - 2026-11-22\n\n* x\n"
    assert is_released(released, "0.1.0")
    assert not is_released(released, "0.2.0")
    assert not is_released(released.replace("Unreleased\n", "Unreleased\n\n* y\n"), "0.1.0")
    for name in ("calibdb.js", "request.js", "package.json"):
        (tmp_path / "sdk").mkdir(exist_ok=True)
        (tmp_path / "sdk" / name).write_bytes((WEB / "sdk" / name).read_bytes())
    monkeypatch.setattr(sdk, "is_released", lambda *_: False)
    before = sdk_version(tmp_path)
    (tmp_path / "sdk/calibdb.js").write_text("// another\n")
    assert sdk_version(tmp_path) != before
    monkeypatch.setattr(sdk, "is_released", lambda *_: True)
    assert sdk_version(tmp_path) == __version__


def test_deployment_keeps_old_versions_and_never_changes_one(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "testing")
    old = Upload("sdk/0.0.8/calibdb.js", b"old", "text/javascript", "x", is_versioned=True)
    new = replace(old, key="sdk/0.0.9/calibdb.js")
    with account():
        s3 = boto3.client("s3", "us-east-1")
        s3.create_bucket(Bucket="web")
        for files in ([old], [new], [new]):
            aws.upload(s3, "web", files)
        with pytest.raises(aws.DeployError, match="another content"):
            aws.upload(s3, "web", [replace(old, content=b"new")])
        assert s3.get_object(Bucket="web", Key=old.key)["Body"].read() == b"old"
