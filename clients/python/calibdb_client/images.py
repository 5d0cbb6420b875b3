"""Recordings of pictures and videos."""

from collections.abc import Iterable
from pathlib import Path

from . import pictures
from .board import Board
from .capture.source import is_video
from .capture.video import read_video
from .key import CameraKey, HasLabel, key_of
from .pictures import MIN_VIEWS, FoundViews
from .recording import Recording


def recording_of(
    paths: str | Path | Iterable[str | Path],
    camera: CameraKey | HasLabel | str,
    board: Board | None = None,
    platform: str | None = None,
    zoom: float | None = None,
    least: int = MIN_VIEWS,
) -> Recording:
    """Find the board in pictures, folders of pictures, or one video file.

    At least `least` views must show it. Parameters and errors as of `Client.calibrate_images`.
    """
    board_views = FoundViews()
    sources = [paths] if isinstance(paths, (str, Path)) else list(paths)
    if len(sources) == 1 and is_video(sources[0]):
        chosen = read_video(sources[0], board, board_views)
    else:
        files = pictures.picture_paths(sources)
        chosen = board or pictures.recognise_board(files)
        pictures.read(files, chosen, board_views)
    size, views = board_views.of_one_size(least)
    if platform is None and isinstance(camera, str):
        platform = pictures.PLATFORM
    return Recording(key_of(camera, platform, size, zoom), chosen, views)
