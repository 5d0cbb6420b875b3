"""`make bench DOCS=domain`: domains that end inside the image, on real sets; writes to docs/accuracy.md.

Every set is fitted with each model, with and without the prior that the domain covers the image.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from calibsolver import CalibrationError, fit, models
from calibsolver.fitting import domain
from calibsolver.quality.cross_validation import held_out
from tests.bench import corners, document

MAX_COVERED = 0.9999


@contextmanager
def without_prior() -> Iterator[None]:
    """Fit without the prior in the block."""
    usual = domain.covering
    domain.covering = lambda *_: None  # type: ignore[assignment]
    try:
        yield
    finally:
        domain.covering = usual


def main() -> None:
    rows, count = [], 0
    for name in corners.NAMES:
        data = corners.load(name)
        views, size = list(data.views), data.img_size
        for model in models.NAMES:
            try:
                with without_prior():
                    before = fit(views, size, model, board_shape=False).camera.domain().covered
                count += 1
                if before >= MAX_COVERED:
                    continue
                after = fit(views, size, model, board_shape=False).camera.domain().covered
                ratio = 1.0
                if after != before:
                    with without_prior():
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
