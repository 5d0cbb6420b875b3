"""Errors of the solver: a calibration that cannot be believed, and a computation that takes too long."""


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


class DeadlineError(Exception):
    """The time that the caller allotted (`deadline.limit`) is up before the computation ended.

    It says nothing of the views, so it is no CalibrationError: whoever tries several fits must not take it
    for a fit that failed.
    """

    def __init__(self) -> None:
        super().__init__("the computation takes longer than the time allotted")
