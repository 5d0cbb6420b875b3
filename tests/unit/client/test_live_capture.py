"""Live captures on this machine: hands-free by words alone, and what is left when they end early."""

import argparse
import contextlib
import io
import os
import pty
import re
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from calibdb_client import Board, Calibration, CameraError, CaptureError, Recording, UsageError, offline
from calibdb_client.capture import source as source_module
from calibdb_client.capture.feedback import Scene, Terminal, draw
from calibdb_client.capture.guide import Status, Target
from calibdb_client.capture.outline import advice, difference, outline_of
from calibdb_client.capture.source import Frames, NamedSource, is_stream, open_source
from calibdb_client.capture.stillness import Stillness
from calibdb_client.capture.video import read_video
from calibdb_client.cli.options import licence_of
from calibdb_client.cli.output import Output
from calibdb_client.detection import Corners
from calibdb_client.pictures import FoundViews
from calibdb_client.session import consent_of
from tests.helpers import board_pictures
from tests.helpers.command import calibdb
from tests.helpers.data import ROOT
from tests.helpers.virtual_person import Listener, VirtualCamera

PICTURE = np.full((48, 64), 100, dtype=np.uint8)


class Tape:
    """Source of given pictures, then of nothing; a file, of which `count` is known, or a camera."""

    def __init__(self, *pictures: Any, count: int = 0) -> None:
        self.pictures, self.count = list(pictures) * max(count, 1), count

    def get(self, number: int) -> float:
        """Number of frames, or the time."""
        return {7: float(self.count), 0: 100.0 * (self.count - len(self.pictures))}[number]

    def read(self) -> tuple[bool, Any]:
        return (True, self.pictures.pop(0)) if self.pictures else (False, None)


def no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_module, "LOST_PAUSE_S", 0)


@pytest.mark.usefixtures("no_suggestion")
def test_capture_that_ends_early_is_kept_and_goes_on(
    working: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C, a camera that is not there, one that is unplugged; then the capture reaches its end."""
    no_pause(monkeypatch)
    camera = VirtualCamera(seed=2)
    listener = Listener(camera)
    read, taken = camera.read, listener.taken
    calibrate: Callable[..., Any] = offline.calibrate

    def press(status: Status) -> None:
        taken(status)
        raise KeyboardInterrupt

    def virtual(source: Any, **arguments: Any) -> Any:
        virtual = {"show": listener, "clock": camera.clock} if source == 0 else {}
        return calibrate(camera if source == 0 else source, **(arguments | virtual))

    monkeypatch.setattr(offline, "calibrate", virtual)
    monkeypatch.setattr(listener, "taken", press)
    assert calibdb("calibrate 0 --offline --squares 9x6") == 130
    assert listener.closed
    (path,) = working.iterdir()
    assert f"`calibdb resume {path.name}` continues" in capfd.readouterr().err
    kept = Recording.load(path)
    assert len(kept.views) == 1
    assert calibdb(f"resume {path.name} 'no such camera' --offline") == 6
    assert "no camera 'no such camera'" in capfd.readouterr().err
    assert Recording.load(path) == kept
    monkeypatch.setattr(listener, "taken", taken)
    monkeypatch.setattr(camera, "read", lambda: read() if listener.views < 2 else (False, None))
    assert calibdb(f"resume {path.name} 0 --offline") == 6
    said = capfd.readouterr().err
    assert "plugged in" in said
    assert "2 views are in" in said
    assert len(Recording.load(path).views) == 2
    monkeypatch.setattr(camera, "read", read)
    assert calibdb(f"resume {path.name} 0 --offline --json") == 0
    calibration = Calibration.load(path)
    assert abs(calibration.camera_matrix[0, 0] - camera.fx) < 2
    assert [each.name for each in working.iterdir()] == [path.name]
    recording = Recording.load(path)
    assert recording.live
    assert 4 <= len(recording.views) <= 8


@pytest.mark.usefixtures("no_suggestion", "working")
def test_video_of_a_board_is_calibrated_and_a_corrupt_one_is_said(capfd: pytest.CaptureFixture[str]) -> None:
    writer = cv2.VideoWriter("board.avi", cv2.VideoWriter.fourcc(*"MJPG"), 1, board_pictures.SIZE)
    for n, tilt in enumerate(board_pictures.TILTS[:5]):
        picture = board_pictures.picture(Board(), tilt, 9.0 + 0.8 * n)
        for _ in range(4):
            writer.write(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    writer.release()
    plain = ["--offline", "--model", "rectilinear", "--squares", "9x6"]
    assert calibdb("calibrate board.avi -o camera.json", *plain) == 0
    found = Calibration.load("camera.json")
    assert np.abs(found.camera_matrix - board_pictures.MATRIX).max() < 3 * found.uncertainty["rms"] + 2
    assert len(Recording.load("camera.json").views) == 5
    content = Path("board.avi").read_bytes()
    Path("cut.avi").write_bytes(content[: len(content) // 4])
    Path("none.mp4").write_bytes(content[1000:5000])
    cut = FoundViews()
    read_video("cut.avi", Board(), cut)
    assert "breaks off after" in cut.broken
    assert cut.views
    assert calibdb("calibrate none.mp4 --offline") == 2
    assert "cannot be read as a video" in capfd.readouterr().err
    # through an object with read(), as a camera: its own time, its end
    capture = cv2.VideoCapture("board.avi")
    assert offline.calibrate(capture, board=Board(), show="none", model="rectilinear").used == 5
    capture.release()


def test_frames_of_another_size_and_lost_ones_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    no_pause(monkeypatch)
    changed = Frames(NamedSource(Tape(PICTURE, PICTURE, PICTURE[:, :32]), "camera 0"))
    first, second = changed.next(), changed.next()
    assert first is not None
    assert second is not None
    assert (first.repeated, second.repeated) == (False, True)
    with pytest.raises(CameraError, match="from 64x48 to 32x48"):
        changed.next()
    with pytest.raises(CameraError, match="camera 0 delivers no picture"):
        _ = Frames(NamedSource(Tape(), "camera 0")).size
    with pytest.raises(CameraError, match="no picture"):
        offline.calibrate(Tape(), board=Board(), show="none")
    with pytest.raises(CaptureError, match="0 views"):
        offline.calibrate(Tape(PICTURE, count=3), board=Board(), show="none")
    with pytest.raises(CaptureError, match="no board was recognised"):
        offline.calibrate(Tape(PICTURE, count=3), show="none")
    with pytest.raises(UsageError, match="delivers 64x48"):
        offline.calibrate(Tape(PICTURE, count=3), show="none", size=(1280, 720))


def corners(offset: float, count: int = 12) -> Corners:
    points = np.stack(np.divmod(np.arange(float(count)), 4), axis=1) * 30 + offset
    return Corners(tuple(range(count)), points)


def test_hold_survives_a_smeared_frame_and_ends_with_motion() -> None:
    still = Stillness()
    for n in range(5):
        still = still.observe(corners(0.3 * (n % 2)), 0.1 * n, 1280)
    assert still.held == pytest.approx(0.4)
    assert still.frames == 4
    assert still.observe(None, 0.5, 1280) is still
    assert still.observe(corners(9.0), 0.5, 1280) is still
    moved = still.observe(corners(9.0), 0.8, 1280)
    assert (moved.held, moved.frames) == (0, 0)
    crept = Stillness()
    for n in range(9):
        crept = crept.observe(corners(1.0 * n), 0.1 * n, 1280)
    assert crept.held < 0.5, "slow movement is movement"
    frozen = Stillness()
    for n in range(9):
        frozen = frozen.observe(corners(0), 0.1 * n, 1280, repeated=True)
    assert frozen.frames == 0, "a camera that stalls is no steady hand"


def seen(
    rvec: tuple[float, float, float] = (0, 0, 0), x: float = 0, y: float = 0, distance: float = 11.0
) -> Any:
    """Outline (4, 2) px of the usual board."""
    board = Board()
    return outline_of(board, range(40), board_pictures.corners(board, rvec, (x, y, distance)))


@pytest.mark.parametrize(
    ("code", "target"),
    [
        ("left", seen(x=-4)),
        ("down", seen(y=3)),
        ("closer", seen(distance=8)),
        ("farther", seen(distance=16)),
        ("turn_clockwise", seen((0, 0, 0.4))),
        ("tilt_top", seen((0.5, 0, 0))),
        ("tilt_left", seen((0, -0.5, 0))),
        ("", seen((0.02, 0.02, 0))),
    ],
)
def test_advice_names_the_movement_that_is_missing(code: str, target: Any) -> None:
    assert advice(seen(), target) == code
    if code.startswith("tilt"):
        assert difference(seen(), target) > 0.08


def test_terminal_gives_settled_words_and_rings(capfd: pytest.CaptureFixture[str]) -> None:
    times = iter(np.arange(0, 100, 0.25).tolist())
    terminal = Terminal(clock=lambda: next(times))
    scene = Scene(PICTURE, None, None, "move the board left", 0.0, Status())
    for _ in range(8):
        terminal.show(scene)
    terminal.show(Scene(PICTURE, None, None, "hold the board still", 0.5, Status()))
    terminal.taken(Status(1, 0.2, 3.0))
    terminal.close()
    assert capfd.readouterr().err.splitlines() == ["move the board left", "view taken: 1 view, 20 %, 3.00 px"]


def test_terminal_of_a_person_shows_progress_without_a_thread() -> None:
    leader, follower = pty.openpty()
    before = threading.active_count()
    with os.fdopen(follower, "w") as stream:
        terminal = Terminal(stream)
        terminal.show(Scene(PICTURE, None, None, "hold the board still", 0.5, Status(2, 0.5, 0.7)))
        assert threading.active_count() == before
        terminal.taken(Status(3, 0.6, 0.5))
        terminal.close()
    printed = b""
    with contextlib.suppress(OSError):  # the end
        while piece := os.read(leader, 65536):
            printed += piece
    os.close(leader)
    assert b"2 views, 50 %, 0.70 px" in printed
    assert b"\a" in printed


def test_window_draws_target_corners_and_words() -> None:
    target = Target(0, (), np.empty((0, 2)), np.array([[10.0, 10], [300, 10], [300, 200]]))
    picture = cv2.resize(PICTURE, (320, 240))
    drawn = draw(Scene(picture, np.array([[50.0, 50]]), target, "hold", 0.5, Status(1, 0.5)))
    assert drawn.shape == (240, 320, 3)
    assert drawn[10, 100].tolist() != [100, 100, 100]
    assert drawn[50, 50, 1] > 150
    large = draw(Scene(np.zeros((2160, 3840, 3), np.uint8), None, None, "hold", 0, Status()))
    assert large.shape == (720, 1280, 3)


def test_sources_are_told_apart(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert is_stream("rtsp://user:secret@camera.example/1")
    assert not is_stream("photos/")
    with pytest.raises(UsageError, match="is not a camera"):
        open_source(object())
    with pytest.raises(CameraError, match=r"stream of 127\.0\.0\.1 cannot be opened") as refused:
        open_source("http://user:secret@127.0.0.1:9/video")
    assert "secret" not in str(refused.value)
    assert calibdb("calibrate http://127.0.0.1:9/video --offline") == 6
    for name, status in (
        ("no such camera", 6),
        ("USB2.0 HD UVC WebCam", 6),
        ("absent.mp4", 2),
        (str(tmp_path / "absent"), 2),
    ):
        assert calibdb(f"calibrate '{name}' --offline") == status
    assert calibdb("calibrate http://127.0.0.1:9/video --licence MIT") == 2
    assert "CC0-1.0" in capfd.readouterr().err


@pytest.mark.parametrize(("answer", "expected"), [("y\n", "CC0-1.0"), ("\n", None), ("no\n", None)])
def test_nobody_agrees_to_the_licence_unasked(
    answer: str, expected: str | None, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    chosen = argparse.Namespace(licence=None, json=False, square_mm=None)
    monkeypatch.setattr("sys.stdin", io.StringIO(answer))
    assert licence_of(chosen, Output()) is None, "nobody is there to answer"
    assert capfd.readouterr().err == ""
    for stream in (sys.stdin, sys.stderr):
        monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)
    assert licence_of(chosen, Output()) == expected
    assert "CC0-1.0" in capfd.readouterr().err
    terms = re.search(r'LICENCE_VERSION = "([0-9-]+)"', (ROOT / "web/lib/consent.js").read_text())
    assert terms, "the client refers to the terms that the pages refer to"
    agreed = {"licence": "CC0-1.0", "licence_version": terms[1]}
    assert consent_of(expected) == (agreed if expected else {})
    with pytest.raises(UsageError):
        consent_of("MIT")
