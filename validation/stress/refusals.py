"""Judges of how input is refused: by an error that names it, in a few words; never by another."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine import Scene, SceneError
from reference_adapters import ReferenceEngine
from validation.playing import run_engine
from validation.stress.trial import Verdict

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

    from validation.stress.plain_scenes import Malformed

# hypothesis is loaded where a trial needs it: the families are listed without.

LONGEST_LINE = 700
"""Characters that a line of a refusal may have: an input of any length is told in a few words."""

FILE = "shot.toml"


def refusal_of(read: Callable[[], object], what: object) -> tuple[str, tuple[str, ...]]:
    """Return the message with which an input is refused, and what is wrong with how it is.

    Parameters
    ----------
    read : callable
        Reads the input.
    what : object
        Its text says which it is.
    """
    try:
        got = read()
    except SceneError as error:
        message = str(error)
    except Exception as error:
        return "", (f"{what} raises {type(error).__name__}: {error}",)
    else:
        return "", (f"{what} is accepted, as {got!r:.200}",)
    faults = []
    if not message:
        faults.append(f"{what} is refused without a word")
    for line in message.splitlines():
        if len(line) > LONGEST_LINE:
            faults.append(f"{what} is refused in {len(line)} characters")
        if not line.isprintable():
            faults.append(f"{what} is refused with characters that break a line: {line!r:.200}")
    return message, tuple(faults)


def told(message: str, tells: tuple[str, ...], what: object, place: str = "") -> tuple[str, ...]:
    """Return what is wrong where no line of a refusal holds all of `tells`, after `place`."""
    if any(
        line.startswith(place) and all(part in line for part in tells)
        for line in message.splitlines()
    ):
        return ()
    return (f"{what}: the refusal should say {', '.join((place, *tells))}: {message!r}",)


def check_malformed(case: Malformed) -> tuple[str, ...]:
    """Return how a malformed scene is not refused as it should be: as plain values, and as text."""
    for read in (partial(Scene.model_validate, case.data), lambda: Scene(**case.data)):
        message, faults = refusal_of(read, case)
        if faults := faults or told(message, case.tells, case):
            return faults
    if not case.plain:
        return ()
    text, line = case.text()
    message, faults = refusal_of(partial(Scene.loads, text, FILE), text)
    place = f"{FILE}:{line}: " if line else f"{FILE}: "
    return faults or told(message, case.tells, text, place)


def check_syntax(case: tuple[str, int]) -> tuple[str, ...]:
    """Return how a text that isn't TOML is not refused as it should be."""
    text, line = case
    message, faults = refusal_of(partial(Scene.loads, text, FILE), text)
    # What isn't closed in one line may be seen in the next one.
    if any(message.startswith(f"{FILE}:{n}: not valid TOML: ") for n in (line, line + 1)):
        return faults
    return faults or (f"{text}: line {line} is wrong, and it is said: {message}",)


def check_anything(content: bytes) -> tuple[str, ...]:
    """Return how a file that holds anything but a scene is not refused as it should be."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / FILE
        path.write_bytes(content)
        message, faults = refusal_of(partial(Scene.load, path), content)
    return faults or told(message, (), content, f"{path}:")


def check_cut(case: tuple[bytes, bytes]) -> tuple[str, ...]:
    """Return how a file that is cut short is not judged: refused, or read as what is left of it."""
    whole, left = case
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / FILE
        path.write_bytes(left)
        try:
            read = Scene.load(path)
        except SceneError as error:
            message = str(error)
        except Exception as error:
            return (f"{left!r} raises {type(error).__name__}: {error}",)
        else:
            right = Scene.loads(whole.decode())
            kept = read.balls[:-1]  # the last one may have lost its last lines
            known = {ball.id: ball for ball in right.balls}
            if len(read.balls) <= len(right.balls) and all(
                ball == known.get(ball.id) for ball in kept
            ):
                return ()
            return (f"{left!r} is read as another scene than it is a part of",)
    return told(message, (), left, f"{path}:")


def check_well_formed(data: dict[str, Any], engine: ReferenceEngine) -> tuple[str, ...]:
    """Return how a scene in order is refused, isn't the same from a file, or isn't run whole."""
    from validation.stress.plain_scenes import written  # noqa: PLC0415

    text, _ = written(data)
    try:
        scene = Scene.model_validate(data)
        same = Scene.loads(text) == scene
    except SceneError as error:
        return (f"{text} is refused: {error}",)
    if not same:
        return (f"{text} is read as another scene than its values",)
    result = run_engine(engine, scene, "rest")
    if not result.status.complete:
        return (f"{text} is not run whole: {result.status.value}: {result.reason}",)
    return ()


def search(
    strategy: SearchStrategy[Any], check: Callable[[Any], tuple[str, ...]], examples: int
) -> Verdict:
    """Check generated inputs; where one isn't judged as it should be, the simplest such is told."""
    import hypothesis  # noqa: PLC0415
    from hypothesis import HealthCheck, Phase, Verbosity  # noqa: PLC0415
    from hypothesis.configuration import set_hypothesis_home_dir  # noqa: PLC0415

    tried = 0

    class BrokenError(Exception):
        """An input that isn't judged as it should be."""

    @hypothesis.seed(1)  # so that a run again tries the same
    @hypothesis.settings(
        max_examples=examples,
        database=None,
        deadline=None,
        derandomize=False,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
        print_blob=False,
        verbosity=Verbosity.quiet,
    )
    @hypothesis.given(strategy)
    def look(case: Any) -> None:
        nonlocal tried
        tried += 1
        if faults := check(case):
            raise BrokenError(faults[0])

    with tempfile.TemporaryDirectory() as folder:
        set_hypothesis_home_dir(
            folder
        )  # it keeps tables of characters; not beside the user's files
        try:
            look()
        except BrokenError as error:
            return Verdict((str(error),), None, 1.0, tried, 1)
        finally:
            set_hypothesis_home_dir(None)
    return Verdict(shots=tried)


def check_refused(path: Path, status: int, output: str, errors: str) -> list[str]:
    """Return what is wrong with how the command ended on a malformed file."""
    faults = []
    if status != 2:
        faults.append(f"exit status {status} instead of 2 for {_content(path)}")
    if "Traceback" in errors:
        faults.append(f"a traceback is shown for {_content(path)}: {errors}")
    if not errors.startswith("error: ") or path.name not in errors:
        faults.append(f"the message doesn't name the file {path}: {errors!r}")
    if output:
        faults.append(f"something is printed as a result of {_content(path)}: {output!r:.200}")
    return faults


def _content(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.exists() else f"{path}, which isn't there"
