"""Pictures of a board in files, and the corners that they show."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from .board import DESCRIBE_IT, Board
from .detection import Detector, recognise
from .detection.recognition import MAX_LOOKED_AT
from .errors import CaptureError, UsageError
from .recording import Progress, RecordedView

T = TypeVar("T")

SUFFIXES = frozenset({".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp"})
UNREAD = frozenset({".heic", ".heif", ".avif", ".dng", ".cr2", ".cr3", ".nef", ".arw", ".raf"})
PLATFORM = "photographs"
"""Platform of pictures that no browser's camera took."""
MAX_PICTURES = 400
"""Pictures that are read; of more, as many spread evenly over their names."""
MAX_VIEWS = 100
MAX_POINTS = 20_000
MIN_VIEWS = 4
"""Views of which the service makes a calibration."""


@dataclass
class FoundViews:
    """Views found in pictures or a video so far, with their picture's size, px.

    Names of pictures without the board, and of files that are not images; the number of frames of a video
    that show the board, and a sentence about one that breaks off.
    """

    views: list[tuple[tuple[int, int], RecordedView]] = field(default_factory=list)
    empty: list[str] = field(default_factory=list)
    frames: int = 0
    broken: str = ""
    unreadable: list[str] = field(default_factory=list)

    def of_one_size(
        self, least: int = MIN_VIEWS, limited: bool = True
    ) -> tuple[tuple[int, int], tuple[RecordedView, ...]]:
        """Return the size that most views have, and those views; `limited` to as many as the service takes.

        Raises CaptureError if there are fewer than `least`.
        """
        if not self.views:
            raise CaptureError(self._nothing())
        sizes = Counter(size for size, _ in self.views)
        size, count = sizes.most_common(1)[0]
        if count < least and self.frames > count:
            raise CaptureError(
                f"{_plural(self.frames, 'frame shows', 'frames show')} the board, but they are too alike: "
                f"{_plural(count, 'view differs', 'views differ')}, and {least} are needed, better 10. "
                "Move the board between the frames, and tilt it in several ways"
            )
        if count < least:
            several = f" of {size[0]}x{size[1]} px" if len(sizes) > 1 else ""
            raise CaptureError(
                f"the board was detected in {_plural(count, 'picture', 'pictures')}{several}, and {least} "
                "are needed, better 10: describe the board by --kind and --squares if it is in more of them"
            )
        views = [view for each, view in self.views if each == size]
        if not limited:
            return size, tuple(views)
        views = _spread(views, MAX_VIEWS)
        while sum(len(view.ids) for view in views) > MAX_POINTS:
            views = _spread(views, len(views) - 1)
        return size, tuple(views)

    def _nothing(self) -> str:
        if self.unreadable and not self.empty:
            return "none of the files can be read as a picture: give JPEG, PNG, TIFF or WebP files"
        return (
            f"the board was detected in none of the pictures: {DESCRIBE_IT}, of an AprilGrid --tag-spacing, "
            "and --legacy if OpenCV before 4.6 drew it"
        )


def picture_paths(given: Iterable[str | Path]) -> list[Path]:
    """List picture files: those given, and those in the folders given, by name.

    Raises UsageError if a path is not there, or a folder has no pictures.
    """
    paths: list[Path] = []
    for each in map(Path, given):
        if each.is_dir():
            inside = sorted(p for p in each.iterdir() if p.suffix.lower() in SUFFIXES and p.is_file())
            if not inside:
                raise UsageError(_without_pictures(each))
            paths += inside
        elif each.is_file():
            if each.suffix.lower() == ".json":
                raise UsageError(f"{each} is not an image: `calibdb submit {each}` uses the corners in it")
            paths.append(each)
        else:
            raise UsageError(f"{each} is not there")
    if not paths:
        raise UsageError("name a folder of pictures, or pictures")
    return paths


def _plural(count: int, one: str, other: str) -> str:
    return f"{count} {one if count == 1 else other}"


def _without_pictures(folder: Path) -> str:
    """Return a sentence about a folder without pictures: where they may be, or how to make some."""
    raw = [path for path in folder.iterdir() if path.suffix.lower() in UNREAD]
    if raw:
        return f"{folder} contains {len(raw)} {raw[0].suffix[1:].upper()} files: convert them to JPEG or PNG"
    below = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    if below:
        names = ", ".join(str(path) for path in below[:5]) + (", …" if len(below) > 5 else "")
        return f"{folder} contains no images, but folders: name one of {names}"
    return f"{folder} contains no images (JPEG, PNG, TIFF, WebP, BMP)"


def turned_by_camera(paths: Sequence[Path]) -> bool:
    """Return True if the first picture has an EXIF orientation, by which other programs turn it."""
    import cv2

    content = _content(paths[0]) if paths else b""
    if not content.startswith(b"\xff\xd8"):
        return False
    plain, turned = _decode(content), _decode(content, cv2.IMREAD_GRAYSCALE)
    return plain is not None and turned is not None and not np.array_equal(plain, turned)


def read(
    paths: Sequence[Path],
    board: Board,
    board_views: FoundViews,
    progress: Progress | None = None,
    most: int | None = MAX_PICTURES,
    mirrored: bool = False,
) -> None:
    """Find the board in pictures, and add to `board_views` one by one: an interruption loses nothing.

    Pixels are those of the file: an orientation that the camera wrote next to them is not applied. `mirrored`
    pictures are turned back. At most `most` pictures are read, spread evenly.
    """
    detector = Detector(board, thorough=True)
    chosen = list(paths) if most is None else _spread(list(paths), most)
    for n, path in enumerate(chosen):
        content = _content(path)
        picture = _decode(content) if content else None
        if mirrored and picture is not None:
            picture = np.ascontiguousarray(picture[:, ::-1])
        if picture is None:
            board_views.unreadable.append(path.name)
        elif (corners := detector.find(picture)) is None:
            board_views.empty.append(path.name)
        else:
            h, w = picture.shape[:2]
            board_views.views.append(((w, h), RecordedView.of(path.name, corners)))
        if progress:
            progress(n + 1, len(chosen))


def recognise_board(paths: Sequence[Path], mirrored: bool = False) -> Board:
    """Return the board in pictures, of which some, spread evenly, are looked at.

    Raises CaptureError if they do not tell, and as `recognise` does.
    """
    chosen = _spread(list(paths), 2 * MAX_LOOKED_AT)
    for some in (chosen[::2], chosen[1::2]):
        pictures = (_decode(content) for path in some if (content := _content(path)))
        board = recognise((each for each in pictures if each is not None), mirrored)
        if board is not None:
            return board
    raise CaptureError(
        f"no board was recognised in the pictures: {DESCRIBE_IT}, and an AprilGrid, of which pictures may "
        "disagree, by --tag-spacing"
    )


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


def _decode(content: bytes, flags: int | None = None) -> Any:
    """Return a picture (h, w) in shades of grey, as the file has it; None if it is none."""
    import cv2

    if flags is None:
        flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        return cv2.imdecode(np.frombuffer(content, dtype=np.uint8), flags)
    except cv2.error:  # more pixels than OpenCV reads
        return None


def _spread(values: Sequence[T], count: int) -> list[T]:
    """Return at most `count` of the values, spread evenly."""
    if len(values) <= count:
        return list(values)
    return [values[n * len(values) // count] for n in range(count)]
