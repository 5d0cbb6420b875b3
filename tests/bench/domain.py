"""`make bench DOCS=domain`: domains that end inside the image, on real sets, with and without their prior."""

from unittest.mock import patch

from calibsolver import CalibrationError, fit, models
from calibsolver.quality.cross_validation import held_out
from tests.bench import corners, document

MAX_COVERED = 0.9999


def main() -> None:
    rows, count = [], 0
    without_prior = patch("calibsolver.fitting.domain.covering", lambda *_: None)
    for name in corners.NAMES:
        data = corners.load(name)
        views, size = list(data.views), data.img_size
        for model in models.NAMES:
            try:
                with without_prior:
                    before = fit(views, size, model, board_shape=False).camera.domain().covered
                count += 1
                if before >= MAX_COVERED:
                    continue
                after = fit(views, size, model, board_shape=False).camera.domain().covered
                ratio = 1.0
                if after != before:
                    with without_prior:
                        plain = held_out(views, size, model, board_shape=False).rms
                    ratio = held_out(views, size, model, board_shape=False).rms / plain
            except CalibrationError:
                continue
            rows.append([name, model, f"{before:.0%}", f"{after:.0%}", f"{ratio:.3f}"])
    header = ["set", "model", "covered without the prior", "with it", "held-out error, ratio"]
    told = f"{count} fits; those not listed cover the image without the prior, and are the same with it."
    document.replace("domain", f"{document.table(header, rows)}\n\n{told}")


if __name__ == "__main__":
    main()
