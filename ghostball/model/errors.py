"""Errors that a user can mend; every one names the field, the rule, the value and what to do."""

from __future__ import annotations


def storable(text: str) -> str:
    r"""Replace lone surrogates, which no file can hold, by Python escapes such as \udcff.

    Applied to every text that comes from an engine, because an engine may return any text.
    """
    return text.encode("utf-8", errors="backslashreplace").decode("utf-8")


class GhostballError(Exception):
    """Base of every error that is shown without a traceback; exit status 2 unless it says else."""


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
        self.features = tuple(map(storable, features))
        super().__init__(
            f"engine `{engine}` can't represent this scene: " + "; ".join(self.features)
        )

    def __reduce__(self) -> tuple[type[UnsupportedSceneError], tuple[str, tuple[str, ...]]]:
        # Exception pickles its message alone; a worker process must hand back both parts.
        return (type(self), (self.engine, self.features))


class EngineFailedError(GhostballError):
    """An engine failed: it raised, crashed, hung, or handed back what no engine may.

    The command line turns it into exit status 1: that engine is wrong, neither the input nor
    ghostball.

    Parameters
    ----------
    engine : str
        Name of the engine.
    reason : str
        What it did.
    trace : str
        Where it was raised; "" where nothing was.
    """

    def __init__(self, engine: str, reason: str, trace: str = "") -> None:
        self.engine = engine
        self.reason = storable(reason)
        self.trace = storable(trace)
        super().__init__(f"engine `{engine}` failed: {self.reason}")

    @property
    def is_our_bug(self) -> bool:
        """Whether our own engine raised something: then it is ghostball that failed."""
        return self.engine == "ghostball" and bool(self.trace)

    def __reduce__(self) -> tuple[type[EngineFailedError], tuple[str, str, str]]:
        return (type(self), (self.engine, self.reason, self.trace))
