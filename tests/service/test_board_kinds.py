"""Sessions of chessboards, AprilGrids and inverted boards, from the request to the stored calibration."""

import json
from typing import Any

import cv2
import numpy as np
import pytest

from calibdb.schema import Board as BoardModel
from calibdb.schema import CalibrationDocument
from calibsolver import Board, View
from calibsolver.formats.grid import grid
from infra.ops.dump import document_row
from tests.helpers.data import corner_views, float32
from tests.helpers.service.client import Client
from tests.helpers.service.published import store
from tests.helpers.solver.export_sources import captured, truth

JOBS = False
USUAL = b'{"squares":[9,6],"marker_ratio":0.65,"dictionary":"DICT_4X4_50","legacy":false}'
APRILGRID = {"kind": "aprilgrid", "squares": [6, 6], "dictionary": "DICT_APRILTAG_36h11"}
CHESSBOARD = {"kind": "chessboard", "squares": [10, 7]}


def ended(client: Client) -> tuple[Any, CalibrationDocument]:
    state = client.finish().json
    return state, store(client.stack).calibrations.get(state["calibration_id"])


def test_board_of_old_is_written_as_it_was() -> None:
    old = BoardModel.model_validate_json(USUAL)
    assert old.kind == "charuco"
    assert old.model_dump_json().encode() == USUAL
    explicit = BoardModel.model_validate_json(b'{"kind":"charuco","inverted":false,"tag_spacing":0.3}')
    assert explicit.model_dump_json().encode() == USUAL


@pytest.mark.parametrize("board", [APRILGRID, CHESSBOARD, {"inverted": True}, {"surface": "screen"}])
def test_board_keeps_its_kind_in_records(board: dict[str, Any]) -> None:
    stored = BoardModel.model_validate_json(json.dumps(board)).model_dump_json()
    of_record = Board.from_record(BoardModel.model_validate_json(stored).model_dump())
    assert of_record == Board(**{**board, "squares": tuple(board.get("squares", (9, 6)))})


def test_real_corners_of_a_chessboard_calibrate(client: Client) -> None:
    views, size = corner_views("opencv_left")
    found = grid(views)
    board = {**CHESSBOARD, "squares": list(found.squares)}
    assert client.open(board=board, img_size=list(size), capture="recorded").status == 201
    numbers = zip(found.ids, views, strict=True)
    sent = [{"ids": list(ids), "points": view.image_points.tolist()} for ids, view in numbers]
    answer = client.call("POST", "/v1/session/batch", {"index": 0, "views": sent}).json
    assert [result["accepted"] for result in answer["results"]] == [True] * len(views)
    shape = client.state()["board_shape"]
    state, document = ended(client)
    _, matrix, *_, deviations, _, _ = cv2.calibrateCameraExtended(*float32(views), size, None, None)
    # Robust weights and a bent board move fx by 0.75 px; plain least squares give OpenCV's to 1e-8 px.
    assert abs(state["calibration"]["camera_matrix"][0][0] - matrix[0, 0]) < 2 * deviations[0][0]
    assert (document.board.kind, document.board.surface) == ("chessboard", None)
    published = document.fits[document.distortion_model].board_shape
    assert shape["sag"] == pytest.approx(published.sag, rel=0.1), "the session states it before its end"
    assert document_row(document)["board_kind"] == "chessboard"


def test_aprilgrid_calibrates_and_is_exported(client: Client) -> None:
    camera = truth("rectilinear")
    board = Board(kind="aprilgrid", squares=(6, 6), dictionary="DICT_APRILTAG_36h11")
    client.open(board=APRILGRID, img_size=list(camera.img_size), capture="recorded")
    for index, view in enumerate(captured(camera, board, count=5)):
        ids, points = numbered(board, view)
        assert client.view(index, ids, points).json["accepted"]
    state, document = ended(client)
    assert abs(state["calibration"]["camera_matrix"][0][0] / camera.matrix[0, 0] - 1) < 0.005
    assert (document.board.kind, document.board.squares) == ("aprilgrid", (6, 6))
    assert client.calibration(document.id, "format=photonvision").status == 200
    refused = client.calibration(document.id, "format=corners-vnl")
    assert (refused.status, "squares" in refused.json["detail"] + str(refused.json["errors"])) == (422, True)


def numbered(board: Board, view: View) -> tuple[list[int], list[list[float]]]:
    places = {tuple(np.round(p, 6)): i for i, p in enumerate(board.points)}
    return [places[tuple(np.round(p, 6))] for p in view.object_points], view.image_points.tolist()


@pytest.mark.parametrize(
    ("board", "field"),
    [
        ({"kind": "aprilgrid"}, "board.dictionary"),
        ({**APRILGRID, "squares": [1, 1]}, "board.squares"),
        ({**APRILGRID, "tag_spacing": 0}, "board.tag_spacing"),
        ({"kind": "chessboard", "squares": [2, 7]}, "board.squares.0"),
        ({**APRILGRID, "dictionary": "DICT_APRILTAG_36h10", "squares": [50, 50]}, "board.squares"),
    ],
)
def test_impossible_boards_are_refused_by_field(client: Client, board: dict[str, Any], field: str) -> None:
    opened = client.open(board=board)
    assert opened.fields == [field], opened.json


def test_corner_beyond_an_aprilgrid_is_refused(client: Client) -> None:
    assert client.open(board=APRILGRID).status == 201
    ids = [0, 1, 2, 3, 4, 144]
    answer = client.view(0, ids, [[100.0 + 9 * i, 100.0 + i * i] for i in ids[:5]] + [[10.0, 10.0]])
    assert answer.status == 422
