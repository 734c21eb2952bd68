"""Errors that a user can mend; every one names the field, the rule, the value and what to do."""

from __future__ import annotations


class GhostballError(Exception):
    """Base of every error caused by input; the command line turns it into exit status 2."""


class SceneError(GhostballError, ValueError):
    """A scene that breaks a rule: which file and line, which field, which value, which rule."""


class UnsupportedSceneError(GhostballError):
    """A valid scene that an engine can't represent; `features` says what it lacks.

    Parameters
    ----------
    engine : str
        Name of the engine.
    features : tuple of str
        One sentence for each missing feature.
    """

    def __init__(self, engine: str, features: tuple[str, ...]) -> None:
        self.engine = engine
        self.features = features
        super().__init__(f"engine `{engine}` can't represent this scene: " + "; ".join(features))

    def __reduce__(self) -> tuple[type[UnsupportedSceneError], tuple[str, tuple[str, ...]]]:
        # Exception pickles its message alone; a worker process must hand back both parts.
        return (type(self), (self.engine, self.features))
