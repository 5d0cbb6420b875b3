"""Guidance over HTTP."""

from calibdb.schema import SessionDocument
from infra.server.server import Server
from tests.helpers.service.client import Client, Truth
from tests.helpers.service.known import consensus, fit
from tests.helpers.service.published import PLATFORM, held, put, store

JOBS = False


def latest(stack: Server, camera: str) -> SessionDocument:
    [document] = [one for one in store(stack).sessions.all() if one.camera == camera]
    return document


def take(client: Client, truth: Truth, views: int) -> None:
    taken = len(client.state()["views"])
    while len(client.state()["views"]) < taken + views:
        assert truth.show(client).status == 200


def test_poses_and_refusals_have_hints(running: Client) -> None:
    truth = Truth()
    first = running.pose().json
    assert (first["hint_code"], first["purpose"]) == ("first", "a first look")
    assert running.view(0, *truth.see(first)).json["accepted"]
    pose = running.pose().json
    assert pose["hint_code"] != "first"
    ids, points = truth.see(pose)
    mirrored = [[1279 - x, y] for x, y in points]
    before = running.state()
    for sent, reason, code in (
        ((ids[:4], points[:4]), "too_few_points", "show_more"),
        ((ids, mirrored), "mirrored", "unmirror"),
        ((ids, points[1:] + points[:1]), "outlier", "hold_still"),
    ):
        answer = running.view(pose["index"], *sent).json
        assert (answer["accepted"], answer["reason"], answer["hint"]["code"]) == (False, reason, code)
        assert running.state() == before
    assert running.pose().json == pose
    assert running.view(pose["index"], ids, points).json["hint"] is None


def test_wrong_first_view_is_set_aside_in_the_state_and_the_report(stack: Server, client: Client) -> None:
    client.open(camera="Camera whose first view was another's", target_error=0.6)
    take(client, Truth(fx=450, fy=450, distortion=(0.0,) * 5), 1)
    state = Truth(seed=3).finish(client, 14)
    first, *others = state["views"]
    assert first["set_aside"]["reason"] in ("outlier", "disagrees")
    assert all(view["set_aside"] is None for view in others)
    kept = store(stack).calibrations.get(state["calibration_id"])
    assert [view.index for view in kept.views] == [view["index"] for view in others]
    assert [view.index for view in kept.set_aside] == [first["index"]]
    assert [view["index"] for view in kept.report["views"]] == [view["index"] for view in others]
    assert state["verdict"] == kept.report["verdict"]


def test_a_refused_view_sent_twice_is_one_witness(stack: Server, client: Client) -> None:
    client.open(camera="Witness camera")
    take(client, Truth(), 3)
    pose = client.pose().json
    view = Truth(fx=1500, fy=1500, seed=5).see(pose)
    answers = [client.view(pose["index"], *view).json for _ in range(4)]
    assert {(answer["accepted"], answer["reason"]) for answer in answers} == {(False, "outlier")}
    assert len(latest(stack, "Witness camera").doubted) == 1
    assert "doubted" not in answers[0]


def test_six_duplicates_in_a_row_end_a_capture_and_undo_cuts_its_course(
    stack: Server, client: Client
) -> None:
    camera = "Camera on a shelf"
    client.open(camera=camera, target_error=0.001)
    truth = Truth(seed=5)
    take(client, truth, 4)
    last = truth.see({"rvec": [0.15, 0.36, 0.14], "tvec": [-2.3, -1.6, 12.0]})  # far from any target
    assert client.view(4, *last).json["accepted"]
    assert [client.view(5, *last).json["reason"] for _ in range(5)] == ["duplicate"] * 5
    before = latest(stack, camera)
    assert client.call("DELETE", "/v1/session/views/4").status == 200
    after = latest(stack, camera)
    assert (before.duplicates, after.duplicates) == (5, 0)
    assert [view.stated for view in after.views] == [view.stated for view in before.views[:4]]
    assert client.view(5, *last).json["accepted"], "it may be shown again"
    assert [client.view(6, *last).json["end"] for _ in range(6)] == [None] * 5 + ["nothing_new"]


def test_capture_starts_from_a_reliable_consensus(stack: Server, client: Client) -> None:
    distances = []
    for name, reason in (("Camera that others measured", None), ("Camera that one measured", "too_few")):
        put(store(stack), consensus(fit((1280, 720), 600.0), camera=name, platform=PLATFORM, reason=reason))
        fresh = Client(stack)
        fresh.open(camera=name, platform=PLATFORM, target_error=0.2)
        distances.append(fresh.pose().json["tvec"][2])
        assert fresh.state()["calibration"] is None
    client.open(camera="Camera that nobody measured", platform=PLATFORM, target_error=0.2)
    # Through a wider lens the same picture is seen from nearer.
    assert distances[0] < 0.75 * client.pose().json["tvec"][2]
    assert distances[1] == client.pose().json["tvec"][2]


def test_seed_that_does_not_pose_the_first_view_is_dropped(stack: Server, client: Client) -> None:
    name = "Camera with a false consensus"
    put(store(stack), consensus(fit((1280, 720), 4000.0), camera=name, platform=PLATFORM))
    client.open(camera=name, platform=PLATFORM)
    assert latest(stack, name).prior is not None
    truth = Truth(seed=6)
    for ids, points in held(truth, 3):
        answer = client.view(client.pose().json["index"], ids, points).json
        assert answer["reason"] not in ("outlier", "degenerate")
        assert latest(stack, name).prior is None
    assert abs(client.state()["calibration"]["camera_matrix"][0][0] / 950 - 1) < 0.02


def test_stored_targets_have_no_corners(client: Client) -> None:
    """Of a dense board they would be most of the session: they follow from the pose and the camera."""
    board = {"squares": [50, 49], "marker_ratio": 0.65, "dictionary": "DICT_6X6_1000", "kind": "chessboard"}
    client.open(camera="Dense", board=board)
    first = client.pose().json
    assert len(first["corners"]) == len(first["ids"]) == 49 * 48
    other = client.pose("skip=1").json
    assert client.pose().json == other, "the same after it was stored"
    document = latest(client.stack, "Dense")
    for target in (document.target, *document.skipped):
        assert not {"ids", "corners", "outline"} & set(target)
    assert len(document.model_dump_json()) < 3_000
