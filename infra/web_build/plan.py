"""Write the poses that the page asks for while it cannot reach the API: `python -m infra.web_build.plan`.

Poses are relative to the board (unit = one square), for the default board and a camera of 1280 x 720 px with
fx = fy = 0.8 widths, no distortion. For another board or size the page scales them.
"""

import json
from pathlib import Path

from calibsolver import Board
from calibsolver.guidance import fixed_plan

PLAN_PATH = Path(__file__).resolve().parents[2] / "web" / "calibrate" / "plan.json"
IMG_SIZE = (1280, 720)


def text() -> str:
    """Return the file's text: a list of `rvec`, `tvec`, `purpose`, `hint`, `hint_code`."""
    poses = [
        {
            "rvec": [round(float(x), 4) for x in pose.rvec],
            "tvec": [round(float(x), 3) for x in pose.tvec],
            "purpose": pose.purpose,
            "hint": pose.hint,
            "hint_code": pose.hint_code,
        }
        for pose in fixed_plan(Board(), IMG_SIZE)
    ]
    return "[\n" + ",\n".join("  " + json.dumps(pose) for pose in poses) + "\n]\n"


if __name__ == "__main__":
    PLAN_PATH.write_text(text())
