"""`make bench DOCS=board-shape`: held-out errors with the board as drawn and in its shape."""

import numpy as np

from calibsolver import CalibrationError
from calibsolver.quality.board_flatness import fit_with_board_shape
from tests.bench import corners, document

MODELS = ("rectilinear", "fisheye")


def main() -> int:
    """Compare on every set that is at hand."""
    rows, ratios = [], []
    for name in corners.NAMES:
        data = corners.load(name)
        for model in MODELS:
            try:
                found = fit_with_board_shape(data.views, data.img_size, model)
            except CalibrationError:
                continue
            if found.shape is None:
                continue
            ratio = found.held_out_shaped / found.held_out
            ratios.append(ratio if found.used else 1.0)
            rows.append(
                [
                    name,
                    model,
                    f"{100 * found.shape.sag:.2f} %",
                    f"{100 * found.shape.stretch:.2f} %",
                    f"{found.held_out:.4f}",
                    f"{found.held_out_shaped:.4f}",
                    f"{100 * (ratio - 1):+.1f} %",
                    "yes" if found.used else "no",
                    "yes" if found.reported else "no",
                ]
            )
            print(*rows[-1], flush=True)
    header = ["set", "model", "sag", "stretch", "held out: drawn, px", "in shape", "", "used", "reported"]
    conclusion = (
        f"Held-out error in use / as drawn: median {np.median(ratios):.3f}, least {min(ratios):.3f}, largest "
        f"{max(ratios):.3f}."
    )
    document.replace("board shape", f"{document.table(header, rows)}\n\n{conclusion}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
