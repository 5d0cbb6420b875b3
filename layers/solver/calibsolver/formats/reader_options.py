"""Facts that a file may lack and its caller may pass: image size, camera, board, model."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ReaderOptions:
    """Facts that a file lacks.

    Attributes
    ----------
    img_size
        Width and height of the pictures, px, for files that do not state them.
    number
        Number of the camera in a file with several, from 0.
    squares
        Columns and rows of the board, for tables of corners.
    model
        Distortion model of coefficients that could be of two: four without a name are k1 k2 p1 p2, or a
        fisheye's k1 to k4.
    """

    img_size: tuple[int, int] | None = None
    number: int = 0
    squares: tuple[int, int] | None = None
    model: str = ""
