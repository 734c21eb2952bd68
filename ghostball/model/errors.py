"""Errors that a user can fix; each message names the field, the rule, the value and the remedy."""

from __future__ import annotations


def storable(text: str) -> str:
    r"""Replace lone surrogates, which no file can hold, by Python escapes such as \udcff.

    Applied to every text that comes from an engine, because an engine may return any text.
    """
    return text.encode("utf-8", errors="backslashreplace").decode("utf-8")


class GhostballError(Exception):
    """Base class of errors that are shown without a traceback; the exit status is usually 2."""


class SceneError(GhostballError, ValueError):
    """A scene breaks a rule; the message names the file, line, field, value and rule."""


class UnsupportedSceneError(GhostballError):
    """A valid scene that an engine doesn't support; `features` lists what is missing.

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
        # `Exception` pickles only its message; a worker process must return both arguments.
        return (type(self), (self.engine, self.features))


class EngineFailedError(GhostballError):
    """An engine failed: it raised an exception, crashed, hung, or returned an invalid result.

    The command line then exits with status 1: the engine is at fault, not the input or Ghostball.

    Parameters
    ----------
    engine : str
        Name of the engine.
    reason : str
        Description of the failure.
    trace : str
        Traceback, or "".
    """

    def __init__(self, engine: str, reason: str, trace: str = "") -> None:
        self.engine = engine
        self.reason = storable(reason)
        self.trace = storable(trace)
        super().__init__(f"engine `{engine}` failed: {self.reason}")

    @property
    def is_our_bug(self) -> bool:
        """Whether Ghostball's own engine raised an exception, which is a bug in Ghostball."""
        return self.engine == "ghostball" and bool(self.trace)

    def __reduce__(self) -> tuple[type[EngineFailedError], tuple[str, str, str]]:
        return (type(self), (self.engine, self.reason, self.trace))
