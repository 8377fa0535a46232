"""The error of whoever asks for a scenario."""


class ScenarioError(ValueError):
    """A scenario or run that cannot be found, read or run, and why."""


class NotInstalledError(ScenarioError):
    """A scenario that needs a Python package which is not installed."""
