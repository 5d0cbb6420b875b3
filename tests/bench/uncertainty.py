"""`make bench DOCS=uncertainty`: predicted errors against those that happen, under white noise."""

import numpy as np

from calibsolver import models
from infra.console import track
from tests.bench import document
from tests.helpers.solver import populations

CAPTURES = 200


def main() -> None:
    rows = []
    for model in track(models.NAMES, "models", len(models.NAMES)):
        for views in (5, 8):
            found = populations.measure(model, CAPTURES, views)
            cover = dict(
                zip(("fx", "fy", "cx", "cy", *models.get(model).coefficients), found.coverage, strict=True)
            )
            low, high = min(cover, key=cover.__getitem__), max(cover, key=cover.__getitem__)
            rows.append(
                [
                    model,
                    str(views),
                    f"{found.projection:.2f}",
                    f"{np.quantile(found.ratio, 0.95):.2f}",
                    f"{np.mean(found.coverage):.1%}",
                    f"{cover[low]:.1%} ({low}) to {cover[high]:.1%} ({high})",
                    str(found.out_of_domain),
                    str(found.failed),
                ]
            )
    header = ["model", "views", "actual / predicted projection error, rms", "95th percentile"]
    header += ["coverage of 95 % intervals", "by parameter", "out-of-domain corner", "failed"]
    document.replace("error bars", document.table(header, rows))


if __name__ == "__main__":
    main()
