"""Bad input: every malformed scene is refused by name, and a NaN that slips through is found."""

from __future__ import annotations

import json
import math
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from engine import Ball, Physics, Scene, SceneError, Status, Table
from reference_adapters import ReferenceEngine
from validation.leash import leashed
from validation.stress.commands import ended, ghostball
from validation.stress.family import Family
from validation.stress.trial import StressError, Suite, Trial, Verdict, blamed_on_engine

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy

    from validation.stress.malformed import Malformed

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
            fewer = len(read.balls) <= len(Scene.loads(whole.decode()).balls)
            return () if fewer else (f"{left!r} is read as more than there is",)
    return told(message, (), left, f"{path}:")


def check_well_formed(data: dict[str, Any], engine: ReferenceEngine) -> tuple[str, ...]:
    """Return how a scene in order is refused, isn't the same from a file, or isn't run whole."""
    from validation.stress.malformed import written  # noqa: PLC0415

    text, _ = written(data)
    try:
        scene = Scene.model_validate(data)
        same = Scene.loads(text) == scene
    except SceneError as error:
        return (f"{text} is refused: {error}",)
    if not same:
        return (f"{text} is read as another scene than its values",)
    with blamed_on_engine():
        result = engine.simulate(scene, record="rest")
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


@dataclass(frozen=True)
class Generated(Trial):
    """Malformed scenes of one kind: each is refused, and told by field, rule, value and place.

    Attributes
    ----------
    name : str
    kind : str
        A kind of mistake, as in `malformed.MISTAKES`; or "syntax", "cut", "anything",
        "well-formed".
    count : int
    """

    name: str
    kind: str
    count: int
    small: ClassVar[bool] = False  # no kernel has a part in it

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Try it."""
        from validation.stress import malformed  # noqa: PLC0415

        texts: dict[str, tuple[SearchStrategy[Any], Callable[[Any], tuple[str, ...]]]] = {
            "syntax": (malformed.bad_syntax(), check_syntax),
            "cut": (malformed.cut_text(), check_cut),
            "anything": (malformed.ANYTHING, check_anything),
            "well-formed": (malformed.well_formed(), partial(check_well_formed, engine=engine)),
        }
        if self.kind in texts:
            strategy, check = texts[self.kind]
            return search(strategy, check, self.count)
        return search(malformed.malformed(self.kind), check_malformed, self.count)


def odd_files(folder: Path) -> Iterator[tuple[str, Path, str]]:
    """Make files that are no scenes, in a folder; yield what each is, its path, and what to say."""

    def file(name: str, content: bytes) -> Path:
        path = folder / name
        path.write_bytes(content)
        return path

    good = b'schema = 1\nname = "a"\n[[balls]]\nid = "cue"\nposition = [0.0, 0.0]\n'
    yield "a file that isn't there", folder / "none.toml", "can't read"
    yield "a folder", folder, "can't read"
    yield "a path that no file can have", folder / "a\0b", "can't read"
    yield "an empty file", file("empty.toml", b""), "`schema` must be given"
    yield "Latin-1", file("latin.toml", good.replace(b'"cue"', b'"k\xf6"')), "not UTF-8"
    yield "half a character", file("half.toml", good + "# ö".encode()[:-1]), "not UTF-8"
    yield "UTF-16", file("utf16.toml", good.decode().encode("utf-16")), "not UTF-8"
    yield "a byte order mark", file("bom.toml", b"\xef\xbb\xbf" + good), "not valid TOML"
    yield "zeros", file("zeros.toml", bytes(10_000)), "not valid TOML"
    yield "brackets", file("deep.toml", b"a = " + b"[" * 100_000), "nested too deeply"
    yield "tables", file("wide.toml", good + b"[" + b"a." * 5_000 + b"a]\n"), "not a known field"
    yield "digits", file("digits.toml", b"t_max = 1" + b"0" * 5_000 + b"\n" + good), "digits"
    yield "a word", file("word.toml", b"x" * 1_000_000), "not valid TOML"
    many = b"".join(b'[[balls]]\nid = "%d"\nposition = [0, nan]\n' % i for i in range(1_000))
    yield "a mistake 1000 times", file("many.toml", good + many), "980 more mistakes"
    heap = b"".join(b'[[balls]]\nid = "%d"\nposition = [0, 0]\n' % i for i in range(1_000))
    yield "1000 balls at one place", file("heap.toml", good + heap), "must not overlap"
    if Path("/dev/zero").exists():
        yield "a device without end", Path("/dev/zero"), "a scene must have at most"


@dataclass(frozen=True)
class OddFiles(Trial):
    """Files that no generator comes upon: none is read for ever."""

    name: str
    small: ClassVar[bool] = False

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - about reading alone
        """Try it."""
        faults: list[str] = []
        tried = broken = 0
        with tempfile.TemporaryDirectory() as folder:
            for what, path, says in odd_files(Path(folder)):
                message, wrong = refusal_of(partial(Scene.load, path), what)
                wrong = wrong or told(message, (says,), what)
                tried, broken = tried + 1, broken + bool(wrong)
                faults += wrong
        return Verdict(tuple(faults), None, float(bool(faults)), tried, broken)


@dataclass(frozen=True)
class CommandLine(Trial):
    """`ghostball simulate FILE` on malformed files: exit status 2, one message, no traceback.

    Attributes
    ----------
    name : str
    count : int
        Of each kind of mistake.
    """

    name: str
    count: int
    limit: ClassVar[float] = 300.0
    small: ClassVar[bool] = False

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - about the command
        """Try it."""
        texts = [text for kind in _KINDS for text in _examples(kind, self.count)]
        faults, broken = [], 0
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for k, text in enumerate(texts):
                paths.append(Path(folder) / f"{k}.toml")
                paths[-1].write_text(text, encoding="utf-8")
            paths.append(Path(folder) / "none.toml")
            for path, (status, output, errors) in zip(paths, simulate_files(paths), strict=True):
                wrong = check_refused(path, status, output, errors)
                broken += bool(wrong)
                faults += wrong
        return Verdict(tuple(faults), None, float(bool(faults)), len(paths), broken)


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


_SIMULATE = """
import contextlib, io, json, sys
from ghostball.cli import app
from validation.leash import end_with_input

end_with_input()

# The files of one process: to start one for each takes longer than all of them.
for path in sys.argv[1:]:
    out, err = io.StringIO(), io.StringIO()
    status = None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            app(["simulate", path])
        except SystemExit as error:
            status = error.code
    print(json.dumps([status, out.getvalue(), err.getvalue()]))
"""


def simulate_files(paths: list[Path]) -> list[tuple[int, str, str]]:
    """Return exit status, output and messages of `ghostball simulate` on each of the files.

    The first one has a process of its own.
    """
    first, *others = map(str, paths)
    alone = ended(ghostball(["simulate", first]), _PATIENCE)
    found: list[tuple[int, str, str]] = [(alone.status, alone.output, alone.errors)]
    if others:
        together = ended(leashed([sys.executable, "-c", _SIMULATE, *others]), _PATIENCE)
        if together.status != 0:
            raise StressError(f"the files were not all tried: {together.errors[-1000:]}")
        found += [tuple(json.loads(line)) for line in together.output.splitlines()]
    return found


def _examples(kind: str, count: int) -> list[str]:
    """Return malformed scenes of a kind, as text."""
    from validation.stress.malformed import bad_syntax, malformed  # noqa: PLC0415

    texts: list[str] = []

    def keep(case: Any) -> tuple[str, ...]:
        text = case[0] if kind == "syntax" else case.text()[0]
        if kind == "syntax" or case.plain:
            texts.append(text)
        return ()

    search(bad_syntax() if kind == "syntax" else malformed(kind), keep, 4 * count)
    return texts[:: max(len(texts) // count, 1)][:count]


_PATIENCE = 140.0
"""Seconds after which commands that should have ended hang; each of two waits once."""

_KINDS = ("numbers", "choices", "types", "missing", "unknown", "relations", "syntax")


# What bypasses the checks.

_FIELDS: tuple[tuple[str, int | None], ...] = (
    *((field, axis) for field in ("position", "velocity", "angular_velocity") for axis in range(3)),
    ("radius", None),
    ("mass", None),
    ("rolling_friction", None),
    ("sliding_friction", None),
    ("spinning_friction_rate", None),
)
"""Numbers of a ball, and the component of those that are vectors."""

_LAWS = (
    "gravity",
    "rolling_friction",
    "sliding_friction",
    "spinning_friction_rate",
    "ball_restitution",
    "ball_friction",
    "cushion_restitution",
    "cushion_tangential_restitution",
    "cushion_friction",
    "cushion_height",
)

UNCHECKED = {
    "rolling": Physics(),
    "sliding": Physics(preset="pool"),
    "integrated": Physics(preset="pool", ball_impact="mathavan2014", cushion="mathavan2010"),
}


def unchecked_base(physics: Physics, count: int) -> Scene:
    """Return a shot in order, in which everything happens: two balls meet, and the cushions."""
    cue = Ball(id="cue", position=(0.3, 0.3), velocity=(1.0, 0.1))
    others = [
        Ball(id=f"b{k}", position=(0.5 + 0.07 * (k % 15), 0.1 + 0.07 * (k // 15)))
        for k in range(count - 1)
    ]
    return Scene(
        name="unchecked",
        physics=physics,
        table=Table(length=2.0, width=1.0),
        t_max=0.5,
        balls=[cue, *others],
    )


def spoilt(base: Scene, value: float) -> Iterator[tuple[str, Scene]]:
    """Yield `base` with each of its numbers in turn replaced, past the checks, and its name."""
    for i in (0, len(base.balls) - 1):
        ball = base.balls[i]
        for field, axis in _FIELDS:
            planted: Any = value
            if axis is not None:
                vector = list(getattr(ball, field) or (0.0, 0.0, 0.0))
                vector[axis] = value
                planted = tuple(vector)
            balls = list(base.balls)
            balls[i] = ball.model_copy(update={field: planted})
            where = f"balls[{i}].{field}" + ("" if axis is None else f"[{axis}]")
            yield where, base.model_copy(update={"balls": tuple(balls)})
    for field in _LAWS:
        physics = base.physics.model_copy(update={field: value})
        yield f"physics.{field}", base.model_copy(update={"physics": physics})
    for field in ("length", "width"):
        assert base.table is not None
        table = base.table.model_copy(update={field: value})
        yield f"table.{field}", base.model_copy(update={"table": table})
    yield "t_max", base.model_copy(update={"t_max": value})


@dataclass(frozen=True)
class Unchecked(Trial):
    """A number that isn't one gets past the checks: the run fails at once, and says where.

    Attributes
    ----------
    name : str
    physics : str
        A key of `UNCHECKED`.
    balls : int
    value : float
    """

    name: str
    physics: str
    balls: int
    value: float
    small: ClassVar[bool] = False  # nothing gets as far as a kernel

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Try it."""
        base = unchecked_base(UNCHECKED[self.physics], self.balls)
        faults: list[str] = []
        tried = 0
        for where, scene in spoilt(base, self.value):
            tried += 1
            with blamed_on_engine():
                result = engine.simulate(scene, record="trajectory")
            says = f"`{where}` is {self.value} at t = 0 s"
            if result.status is not Status.FAILED or says not in result.reason:
                faults.append(
                    f"`{where}` = {self.value}: {result.status.name} with the reason "
                    f"{result.reason!r} instead of FAILED with {says!r}"
                )
                continue
            with np.errstate(all="ignore"):
                sampled = result.sample([0.0]).positions
            if sampled.shape != (1, self.balls, 3):
                faults.append(f"`{where}` = {self.value}: what is returned can't be sampled")
        return Verdict(tuple(faults), None, float(bool(faults)), tried, len(faults))

    def examples(self) -> Iterator[Scene]:
        """Yield the scene in order."""
        yield unchecked_base(UNCHECKED[self.physics], self.balls)


@dataclass(frozen=True)
class Overflow(Trial):
    """Speeds, times and places so large that products of them may overflow: finite, or FAILED.

    Attributes
    ----------
    name : str
    physics : str
    """

    name: str
    physics: str
    small: ClassVar[bool] = False  # interpreted, a division by zero raises

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Try it."""
        faults: list[str] = []
        tried = 0
        for scene in self.examples():
            tried += 1
            with blamed_on_engine():
                result = engine.simulate(scene, record="events")
            finite = all(bool(np.all(np.isfinite(part))) for part in result.final_state)
            if result.status is Status.FAILED and result.reason:
                continue
            if not finite or not math.isfinite(result.rest_time):
                faults.append(f"{scene.balls[0].velocity}: {result.status.name}, but not finite")
        return Verdict(tuple(faults), None, float(bool(faults)), tried, len(faults))

    def examples(self) -> Iterator[Scene]:
        """Yield the scenes."""
        base = unchecked_base(UNCHECKED[self.physics], 3)
        for speed in (1e10, 1e30, 1e50):
            for t_max in (1e-40, 1.0, 1e50):
                cue = base.balls[0].model_copy(update={"velocity": (speed, 0.1 * speed, 0.0)})
                balls = (cue, *base.balls[1:])
                yield Scene(
                    name="fast",
                    physics=base.physics,
                    t_max=t_max,
                    balls=balls,
                    table=None,
                )


def _trials(suite: Suite) -> Iterator[Trial]:
    full = suite == "full"
    examples = 2_000 if full else 60
    for kind in (*_KINDS, "cut", "anything", "well-formed"):
        yield Generated(kind, kind, examples)
    yield OddFiles("odd-files")
    yield CommandLine("command-line", 20 if full else 2)
    for physics in UNCHECKED:
        for count in (3, 120):
            for value in (math.nan, math.inf, -math.inf) if full else (math.nan, math.inf):
                yield Unchecked(f"unchecked-{physics}-{count}-{value}", physics, count, value)
        yield Overflow(f"overflow-{physics}", physics)


FAMILY = Family(
    "bad-input",
    "Malformed scenes and NaN",
    "Every malformed scene, as plain values, as text or as a file, is refused with an error that "
    "names field, rule, value and place; none crashes, hangs or is half run, nor is a valid one "
    "refused. A NaN that gets past the checks ends the run at once, saying which number it is.",
    _trials,
    ours_alone=True,
)
