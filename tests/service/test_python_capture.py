"""Live captures, checks and other boards of the Python client against the local stack."""

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import pytest

from calibdb_client import (
    AsyncClient,
    Board,
    CameraKey,
    CaptureResult,
    Client,
    NotFoundError,
    Recording,
)
from calibdb_client.capture.outline import TEXTS
from infra.server.server import Server
from tests.helpers import virtual_person
from tests.helpers.service.client import Client as Raw
from tests.helpers.service.client import until
from tests.helpers.virtual_person import Listener, VirtualCamera

TOKEN = "cdb_dev_local"
LABEL, PLATFORM = "USB2.0 HD UVC WebCam (13d3:5a01)", "X11; Linux x86_64"


@pytest.fixture(scope="module", autouse=True)
def quick_hands() -> Iterator[None]:
    """People who move three times as far in the time of a frame: a third as many frames are looked at."""
    with pytest.MonkeyPatch.context() as patch:
        for move in ("STEP", "TURN"):
            patch.setattr(virtual_person, move, 3 * getattr(virtual_person, move))
        yield


@dataclass
class Captured:
    result: CaptureResult
    recording: Recording
    camera: VirtualCamera


@pytest.fixture(scope="module")
def captured(url: str) -> Captured:
    camera = VirtualCamera(seed=2)
    kept = []
    how = {"label": LABEL, "platform": PLATFORM, "board": Board(), "clock": camera.clock}
    with Client(url, TOKEN, cache=False) as client, pytest.MonkeyPatch.context() as patch:
        patch.setattr("calibdb.rules.session_rules.TARGET_ERROR_PER_WIDTH", 0.01)  # four views are enough
        result = client.calibrate(camera, licence="CC0-1.0", show=Listener(camera), keep=kept.append, **how)
        return Captured(result, kept[-1], camera)


def test_service_guides_by_words_in_at_most_eight_views(served: str, captured: Captured) -> None:
    result = captured.result
    assert result.verdict[0] in ("good", "fair")
    assert result.used <= 8
    sigma = result.calibration.uncertainty["rms"]
    assert abs(result.calibration.camera_matrix[0, 0] - VirtualCamera().fx) < 3 * sigma + 1
    with Client(served, TOKEN, cache=False) as client:
        stored = client.calibration(result.calibration.id)
    assert (stored.record["licence"], stored.record["platform"]) == ("CC0-1.0", PLATFORM)


@pytest.mark.usefixtures("captured")
def test_check_takes_three_glances_of_different_tilts(served: str, stack: Server) -> None:
    asked = {"camera": LABEL, "platform": PLATFORM, "img_size": [640, 480], "redirect": False}
    until(lambda: Raw(stack).lookup(**asked).json["reason"] == "too_few")  # the consensus comes after
    camera = VirtualCamera(seed=3)
    listener = Listener(camera)
    how = {"label": LABEL, "platform": PLATFORM, "show": listener, "clock": camera.clock}
    with Client(served, TOKEN, cache=False) as client:
        # three glances, tilted as the words say
        tilts = iter(["tilt_top", "tilt_left", "tilt_bottom", "tilt_right"] * 9)
        take = listener.show
        turn = []

        def obey(scene: Any) -> str:
            take(scene)
            if scene.instruction.startswith("tilt"):
                turn[:] = turn or [next(tilts)]
                camera.words = TEXTS[turn[0]]
            else:
                turn.clear()
            return ""

        listener.show = obey
        check = client.check(camera, board=Board(), **how)
        assert check.fits
        assert check.error < 2 * check.expected
        assert check.calibration.id


@pytest.mark.thorough
def test_asynchronous_twin_resumes_a_capture(served: str, captured: Captured) -> None:
    # The board is where it was for the last view, which is wanted again.
    camera = VirtualCamera(seed=2)
    camera.place, camera.rotation = captured.camera.place, captured.camera.rotation
    begun = replace(captured.recording, views=captured.recording.views[:-1])
    ticks = 0

    async def tick() -> None:
        nonlocal ticks
        while True:
            await asyncio.sleep(0.005)
            ticks += 1

    async def resume() -> CaptureResult:
        async with AsyncClient(served, TOKEN, cache=False) as client:
            other = asyncio.create_task(tick())
            with pytest.raises(NotFoundError):
                await client.check(replace(begun, key=CameraKey("Nobody", PLATFORM, camera.size)))
            result = await client.calibrate(camera, resume=begun, show=Listener(camera), clock=camera.clock)
            other.cancel()
            return result

    result = asyncio.run(resume())
    assert result.used <= 8
    assert abs(result.calibration.camera_matrix[0, 0] - camera.fx) < 2
    assert ticks > 10, "the loop goes on while frames are read"
