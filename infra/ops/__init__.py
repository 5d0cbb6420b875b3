"""The operator's tools."""


class OpsError(ValueError):
    """A command cannot be executed; the message states the reason."""
