"""Values of the example requests of the API.

`SESSION_ID`, `MANAGEMENT_TOKEN`, `CALIBRATION_ID`, `RIG_ID` and `CAMERA_KEY` stand for values from earlier
responses.
`infra.web_build.recorded_examples` sends the requests and records the responses.
"""

from __future__ import annotations

EXAMPLE_CAMERA = "HD Pro Webcam C920 (046d:082d)"
EXAMPLE_PLATFORM = "X11; Linux x86_64"
EXAMPLE_KEY = {"camera": EXAMPLE_CAMERA, "platform": EXAMPLE_PLATFORM, "img_size": [1280, 720]}
EXAMPLE_BOARD = {"squares": [9, 6], "marker_ratio": 0.65, "dictionary": "DICT_4X4_50", "legacy": False}
EXAMPLE_IDS = [0, 1, 2, 8, 9, 10, 16]
EXAMPLE_POINTS = [
    *([412.3, 207.9], [498.1, 214.0], [585.6, 220.7], [405.2, 291.4], [492.8, 298.9], [582.0, 306.8]),
    [398.0, 377.1],
]

EXAMPLE_FILE = (
    "image_width: 1280\nimage_height: 720\ncamera_name: c920\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [952.1, 0, 644.8, 0, 951.7, 358.2, 0, 0, 1]\ndistortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.09, -0.19, 0.0004, -0.0007, 0.0]\n"
)
"""A file of ROS."""
