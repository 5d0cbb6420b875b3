"""A deployment uploads a site that holds together, keeps its secrets, and says what it would do."""

import hashlib
import json
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from calibdb.access.tokens import SessionIds, Ticket
from infra.deploy import aws, layers, package, rehearsal, steps
from infra.deploy.__main__ import main
from infra.deploy.site import FOREVER, Upload, uploads
from infra.web_build.site_headers import media_type
from tests.helpers.aws import account
from tests.helpers.sam import complete

ROOT = Path(__file__).parents[2]
SETTINGS = {"api": "/v1", "token": "cdb_page_secret"}


@pytest.fixture(scope="module")
def site() -> dict[str, Upload]:
    return {file.key: file for file in uploads(ROOT / "web", SETTINGS)}


@pytest.fixture
def cloud() -> Iterator[aws.Account]:
    with account():
        yield aws.Account("one", "us-east-1")


def test_files_named_by_another_are_uploaded_and_of_one_release(site: dict[str, Upload]) -> None:
    """No page, and no module that a page loads, names a script or style that may be of another release."""
    forever = {key for key, file in site.items() if file.cache_control == FOREVER}
    address = rb"""["'](\.{0,2}/[^"'?#]*\.[a-z0-9]+)["']"""
    in_page = re.compile(b"(?:src|href)=" + address)
    in_module = re.compile(rb"(?:\bfrom\s*|\bimport\(?\s*|new URL\()" + address)
    named = 0
    for key, file in site.items():
        if key.startswith("vendor-") or not key.endswith((".js", ".html")):
            continue
        of_a_release = key.endswith(".html") or (key in forever and not re.match(r"sdk/\d", key))
        for match in (in_page if key.endswith(".html") else in_module).finditer(file.content):
            line = file.content[: match.start()].rpartition(b"\n")[2]
            if line.lstrip().startswith((b"*", b"//", b"/*")):
                continue  # of types, in a comment
            there = posixpath.normpath(posixpath.join("/", posixpath.dirname(key), match[1].decode()))[1:]
            if there.startswith("dumps/"):
                continue  # of a function
            assert there in site, (key, there)
            if of_a_release and there.endswith((".js", ".css")) and there != "sw.js":
                assert there in forever, (key, there)
            named += 1
    assert named > 1000


def test_uploads_have_type_encoding_and_cache_control(site: dict[str, Upload]) -> None:
    forever = {key for key, file in site.items() if file.cache_control == FOREVER}
    (named,) = {match[1] for key in site if (match := re.match(r"calibrate/main-([0-9a-f]{12})\.js$", key))}
    assert forever == {key for key in site if re.match(r"vendor-\w{12}/|sdk/\d", key) or f"-{named}." in key}
    versions = {key for key, file in site.items() if file.is_versioned}
    assert versions == {key for key in forever if re.match(r"sdk/\d", key)} != set()
    # What pages load changes its name; the rest is for other origins, the edge's 404 page and the browser.
    plain = {key for key in site.keys() - forever if key.endswith((".js", ".css"))}
    assert {re.sub(r"/.*", "/", key) for key in plain} == {"sdk/", "webxr/", "style.css", "sw.js"}
    assert "lib/detector-" + named + ".worker.js" in site, "CloudFront knows workers by their suffix"
    assert not any(key.startswith("vendor/") for key in site)
    (wasm,) = (file for key, file in site.items() if key.endswith(".wasm"))
    # The edge compresses it, as it does all files of at most 10 MB.
    assert (wasm.content_type, wasm.content_encoding) == ("application/wasm", None)
    assert wasm.content == (ROOT / "web/vendor/opencv/opencv.wasm").read_bytes()
    for key, file in site.items():
        assert file.content_type == media_type(key)
        assert len(file.content) < 10_000_000
    assert list(site)[-2:] == ["shell.json", "config.json"]
    assert site["config.json"].cache_control == "no-store"
    assert json.loads(site["config.json"].content) == SETTINGS


def test_service_worker_finds_every_file_of_its_list_as_it_is_uploaded(site: dict[str, Upload]) -> None:
    listed = json.loads(site["shell.json"].content)
    assert {"index.html", "calibrate/index.html"} <= set(listed["files"])
    (main,) = (name for name in listed["files"] if name.startswith("calibrate/main-"))
    assert f'src="/{main}"'.encode() in site["calibrate/index.html"].content
    for name, digest in listed["files"].items():
        assert hashlib.sha256(site[name].content).hexdigest() == digest, name
    assert [name for name in listed["late"] if name.startswith("vendor-") and name.endswith(".wasm")]
    assert not [name for name in listed["files"] if "engines/" in name or name.startswith("examples/")]


def test_a_change_in_one_module_renames_them_all(tmp_path: Path) -> None:
    for folder in ("lib", "vendor"):
        (tmp_path / folder).mkdir()
    (tmp_path / "index.html").write_text('<script type="module" src="/main.js"></script>')
    (tmp_path / "main.js").write_text(
        'import { x } from "./lib/x.js"; import "./vendor/v.js"; await import("./lib/y.worker.js"); // vendor'
    )
    (tmp_path / "lib/y.worker.js").write_text(
        'new URL("./z.json", import.meta.url); new URL("../", import.meta.url);'
    )
    (tmp_path / "lib/z.json").write_text("{}")

    def made(content: str) -> tuple[dict[str, bytes], str, str]:
        for file in ("lib/x.js", "vendor/v.js"):
            (tmp_path / file).write_text(content)
        files = {file.key: file.content for file in uploads(tmp_path, {})}
        (digest,) = (key[5:17] for key in files if key.startswith("main-"))
        (vendor,) = (key for key in files if key.startswith("vendor"))
        return files, digest, vendor

    files, digest, vendor = made("export const x = 1;")
    _, other_digest, other_vendor = made("export const x = 2;")
    assert digest != other_digest
    assert vendor != other_vendor
    assert files["index.html"] == f'<script type="module" src="/main-{digest}.js"></script>'.encode()
    assert files[f"main-{digest}.js"].decode() == (
        f'import {{ x }} from "./lib/x-{digest}.js"; import "./{vendor}"; '
        f'await import("./lib/y-{digest}.worker.js"); // vendor'
    )
    assert (
        f'new URL("./z-{digest}.json", import.meta.url); new URL("../",'.encode()
        in (files[f"lib/y-{digest}.worker.js"])
    )
    assert list(files).index(f"lib/x-{digest}.js") < list(files).index("index.html")


def test_upload_sets_the_headers(site: dict[str, Upload], cloud: aws.Account) -> None:
    s3 = cloud.client("s3")
    s3.create_bucket(Bucket="web")
    assert aws.settings(s3, "web") == {}
    few = [
        site["index.html"],
        site["config.json"],
        site["dumps/statistics.json"],
        Upload("x.wasm", b"1", "application/wasm", FOREVER, "gzip"),
    ]
    assert aws.upload(s3, "web", few) == 4
    head = s3.head_object(Bucket="web", Key="x.wasm")
    assert (head["ContentType"], head["ContentEncoding"], head["CacheControl"]) == (
        "application/wasm",
        "gzip",
        FOREVER,
    )
    assert aws.settings(s3, "web") == SETTINGS
    s3.put_object(Bucket="web", Key="dumps/statistics.json", Body=b"of a dump")
    aws.upload(s3, "web", few)
    kept = s3.get_object(Bucket="web", Key="dumps/statistics.json")["Body"].read()
    assert kept == b"of a dump", "a later upload leaves the figures"


def test_secrets_are_made_once(cloud: aws.Account) -> None:
    assert cloud.make_secrets() == list(aws.SECRETS)
    before = values(cloud)
    assert cloud.make_secrets() == []
    assert values(cloud) == before
    assert before["EDGE_SECRETS"].split(",")[0] == before["EDGE_SECRET"]
    assert all(len(key) == 64 for value in before.values() for key in value.split(","))
    made = {p["Name"].rpartition("/")[2]: (p["Type"], p["Value"].count(",") + 1) for p in parameters(cloud)}
    assert made == {
        "SESSION_SECRETS": ("SecureString", 2),
        "CONTRIBUTOR_SECRET": ("SecureString", 1),
        "EDGE_SECRETS": ("SecureString", 2),
        "EDGE_SECRET": ("String", 1),
    }


def test_secret_that_cloudfront_sends_is_kept_if_the_list_is_lost(cloud: aws.Account) -> None:
    cloud.client("ssm").put_parameter(Name="/calibdb/one/EDGE_SECRET", Value="e" * 64, Type="String")
    cloud.make_secrets()
    assert values(cloud)["EDGE_SECRET"] == values(cloud)["EDGE_SECRETS"].split(",")[0] == "e" * 64


def test_a_rotation_of_the_edge_loses_no_address(cloud: aws.Account) -> None:
    """Functions, the early and the late, take all that the edge sends until it learns of the rotation."""
    cloud.make_secrets()
    sent, taken = [values(cloud)["EDGE_SECRET"]], [values(cloud)["EDGE_SECRETS"].split(",")]
    for version in (2, 3, 4):
        assert cloud.rotate_edge() == cloud.edge_secret_version() == version
        sent.append(values(cloud)["EDGE_SECRET"])
        taken.append(values(cloud)["EDGE_SECRETS"].split(","))
        for secret in sent[-2:]:
            assert all(secret in known for known in taken[-2:])
    assert len(set(sent)) == 4
    assert sent[0] not in taken[-1]


def test_a_rotation_refuses_nobody_while_functions_learn_of_it(cloud: aws.Account) -> None:
    cloud.make_secrets()
    ids = [session_ids(cloud)]
    for _ in range(3):
        cloud.rotate()
        ids.append(session_ids(cloud))
        late, early = ids[-2:]
        for signer, verifier in ((late, early), (early, late)):
            session_id, _ = signer.issue(Ticket("6553f1000123456789abcdef", "dev", None))
            assert verifier.verify(session_id, None).token == "dev"


def parameters(cloud: aws.Account) -> list[dict[str, str]]:
    stored = cloud.client("ssm").get_parameters_by_path(Path="/calibdb/one", WithDecryption=True)
    found: list[dict[str, str]] = stored["Parameters"]
    return found


def values(cloud: aws.Account) -> dict[str, str]:
    return {p["Name"].rpartition("/")[2]: p["Value"] for p in parameters(cloud)}


def session_ids(cloud: aws.Account) -> SessionIds:
    return SessionIds(tuple(values(cloud)["SESSION_SECRETS"].split(",")), lambda: 1.7e9)


def test_a_plan_needs_no_credentials_and_names_every_step(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--plan", "--stack", "mine", "AlarmEmail=a@example.org"]) == 0
    plan = capsys.readouterr().out
    assert "--stack-name mine" in plan
    assert "AlarmEmail=a@example.org" in plan
    numbered = [line for line in plan.splitlines() if re.match(r"\d+\. ", line)]
    kinds = [step.kind for step in steps.steps(steps.Target("mine", "us-east-1"))]
    assert len(numbered) == len(kinds) == 13
    assert kinds[0] == "account"
    assert kinds.index("package") > kinds.index("build")  # the layers, whose content names the release
    # With a domain the address is known beforehand.
    own = steps.Target("mine", "us-east-1", {"DomainName": "x.example"}, "https://x.example")
    kinds = [step.kind for step in steps.steps(own)]
    assert (kinds.count("run"), kinds.count("package")) == (2, 1)


@pytest.mark.parametrize(
    ("parameter", "complaint"),
    [
        ("MinShare=0.7", "the template has no parameter MinShare"),
        ("Thresholds=MIN_SHARES=0.7", "THRESHOLDS holds 'MIN_SHARES=0.7', which is not a threshold"),
        ("Thresholds", "a parameter is written NAME=VALUE"),
        ("PlanFactors=pages=2", "there is no plan pages"),
    ],
)
def test_wrong_parameter_is_refused_before_the_first_step(
    parameter: str, complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--plan", parameter])
    assert ended.value.code == 2
    assert complaint in capsys.readouterr().err


def test_packaged_template_names_existing_paths() -> None:
    text = json.dumps(package.package_template(complete()))
    places = re.findall(r'"(?:CodeUri|ContentUri|DefinitionUri)": "([^"]+)"', text)
    assert len(places) == 19
    for place in places:
        there = (package.TEMPLATE.parent / place).resolve().relative_to(ROOT).as_posix()
        assert there.startswith(("functions/", ".build/layers/", "infra/backfill")), there


def test_rehearsal_leaves_out_its_listed_resources_alone() -> None:
    left = rehearsal.remove_unsupported(package.complete_template())["Resources"]
    assert set(complete()["Resources"]) - set(left) == set(rehearsal.UNSUPPORTED)


def test_oversized_layers_are_named() -> None:
    fine = layers.BuiltLayer(20.0, 1.0, ())
    assert list(layers.problems(fine, layers.BuiltLayer(148.0, 1.0, ()), 0.1)) == []
    found = list(layers.problems(fine, layers.BuiltLayer(181.0, 0.5, ("a.x86_64-linux-gnu.so",)), 0.1))
    assert len(found) == 3
