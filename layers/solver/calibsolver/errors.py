"""The one error of the solver."""


class CalibrationError(Exception):
    """A calibration that cannot be believed is never returned: this says why.

    Parameters
    ----------
    code
        Short and stable, for programs: ``too_few_points``, ``degenerate``, ``no_fit`` and the like.
    message
        One sentence for people.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
