"""The columns of the board: each measures one thing of an engine, and says what it is worth.

A column is a function of an engine to a `Cell`. Its worth is told apart from the engine's design:
which law of simultaneous impacts an engine plays is no error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import Result, Scene
from ghostball.reference_adapters.base import EngineError, ReferenceEngine
from ghostball.reference_adapters.registry import make_engine, parse_spec, spec_of
from ghostball.validation.board import shots
from ghostball.validation.board.installed import installed_size
from ghostball.validation.board.playing import play
from ghostball.validation.board.reported import REPORTED, Reported
from ghostball.validation.board.right import proved_end
from ghostball.validation.board.starting import start_time
from ghostball.validation.checks.accuracy import kind_of
from ghostball.validation.results.records import Motion
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.runs.steps import step_setting

FloatArray = NDArray[np.float64]

Worth = Literal["good", "fair", "bad", "design", "none", "failed"]
"""What a cell is worth.

Right; right to what its step lets one expect; wrong; by design another law; no value, for the
engine lacks what the question is of; not measured, for the engine crashed, hung or raised.
"""

STEP: Final = 1e-3
"""Step of the native single hits [s]."""

MOST_STEPS: Final = 1_000_000
"""Steps after which a cut to rest is given up."""

LADDER: Final = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)
"""Steps of the native cuts to rest [s]."""

LAWS: Final[Mapping[str, Mapping[str, tuple[float, ...]]]] = {
    "line": {
        "Moreau": (-1 / 3, 2 / 3, 2 / 3),
        "sequential": (0.0, 0.0, 1.0),
        "plastic": (1 / 3, 1 / 3, 1 / 3),
    },
    "two": {"Moreau": (-0.2, 0.6, 0.6), "plastic": (0.4, 0.3, 0.3)},
}
"""Speeds along the cue ball's line, over its first, of the laws that are known."""


@dataclass(frozen=True)
class Cell:
    """What one engine shows of one question.

    Attributes
    ----------
    value : float or None
        To sort by, in the column's unit; None where there is none.
    text : str
        What the board shows.
    worth : Worth
    note : str
        Why there is no value, or more of it.
    """

    value: float | None
    text: str
    worth: Worth
    note: str = ""


@dataclass(frozen=True)
class Column:
    """A question.

    Attributes
    ----------
    title, unit : str
    asks : str
        The question, for the key beneath the board.
    shot : Scene
        What it is asked with; some vary it.
    measure : callable
        Given a spec.
    shown : callable
        Given a spec, the one whose play of `shot` answers; None where no motion does.
    """

    title: str
    unit: str
    asks: str
    shot: Scene
    measure: Callable[[str], Cell]
    shown: Callable[[str], str | None] = lambda _: None

    def motion(self, spec: str) -> Motion | None:
        """Play the shot once more, to be seen; None where no motion shows the answer."""
        shown = self.shown(spec)
        if shown is None:
            return None
        return motion_of(play(make_engine(shown), self.shot, record="trajectory"))


def with_settings(spec: str, **settings: Any) -> str | None:
    """Return a spec with more settings, or None where the engine doesn't have them or refuses.

    What the spec says stays as it is.
    """
    if not set(settings) <= set(type(make_engine(spec)).Settings.model_fields):
        return None
    name, said = parse_spec(spec)
    changed = spec_of(name, said | {key: settings[key] for key in settings if key not in said})
    try:
        make_engine(changed)
    except EngineError:  # settings that exclude each other
        return None
    return changed


def native(spec: str, dt: float) -> str | None:
    """Return a spec with fixed steps of `dt` [s]; None where the engine has none or refuses."""
    engine = make_engine(spec)
    name = step_setting(engine)
    if name is None:
        return None
    more = {"mode": "native", "max_steps": MOST_STEPS, "max_events": MOST_STEPS}
    known = {key: more[key] for key in more if key in type(engine).Settings.model_fields}
    return with_settings(spec, **{name: dt}, **known)


def _as_it_is(spec: str) -> str:
    return spec


def _stepped(spec: str) -> str:
    return native(spec, STEP) or spec


def _landed(spec: str) -> str | None:
    landed = with_settings(spec, mode="landed")
    if landed is None or getattr(make_engine(landed).settings, "mode", None) != "landed":
        return None
    return landed


def _landed_if_it_can(spec: str) -> str:
    return _landed(spec) or spec


def cut(spec: str) -> Cell:
    """Measure how far off 30 degrees an object ball leaves, in the worst of 8 phases of a step."""
    stepped = native(spec, STEP)
    return _cut(make_engine(stepped or spec), STEP if stepped else 0.0)


def landed_cut(spec: str) -> Cell:
    """Measure the same, where steps end on contacts."""
    landed = _landed(spec)
    if landed is None:
        return Cell(None, "", "none", "it has no steps that end on contacts")
    return _cut(make_engine(landed), 0.0)


def _cut(engine: ReferenceEngine, dt: float) -> Cell:
    off = []
    for phase in np.arange(8) / 8:
        scene = shots.half_ball(0.5 - phase * shots.SPEED * dt)
        x, y = play(engine, scene).final_state.velocities[0, 1, :2]
        off.append(abs(math.degrees(math.atan2(-y, x)) - 30.0))
        if dt == 0.0:
            break
    worst = max(off)
    # What the angle makes of a metre.
    kind = kind_of(math.radians(worst))
    worth: Worth = "good" if kind in ("nanometres", "micrometres") else "fair"
    return Cell(worst, f"{worst:.2g}", worth if worst < 1.0 else "bad")


def line(spec: str) -> Cell:
    """Find out which law a frozen line plays."""
    return _law(spec, shots.frozen_line(), LAWS["line"])


def one_into_two(spec: str) -> Cell:
    """Find out which law one ball into two plays."""
    return _law(spec, shots.one_into_two(), LAWS["two"])


def _law(spec: str, scene: Scene, laws: Mapping[str, tuple[float, ...]]) -> Cell:
    result = play(make_engine(spec), scene)
    speeds = result.final_state.velocities[0, :, 0] / shots.SPEED
    shown = ", ".join(f"{speed:.3f}" for speed in speeds)
    for law, wanted in laws.items():
        if np.abs(speeds - wanted).max() < 0.01:
            off = float(np.abs(speeds - wanted).max())
            return Cell(off, law, "bad" if law == "plastic" else "design", shown)
    kept = float(np.sum(result.final_state.velocities[0] ** 2)) / shots.SPEED**2
    worth: Worth = "design" if abs(kept - 1.0) < 0.01 else "bad"
    return Cell(None, "other" if worth == "design" else f"energy x {kept:.2f}", worth, shown)


def energy(spec: str) -> Cell:
    """Measure what three breaks make of their energy: the most made, or else the most lost."""
    engine = make_engine(spec)
    made, left = 0.0, 1.0
    for shift in (0.001, 0.002, 0.003):
        scene = shots.rack(shift)
        result = play(engine, scene, record="trajectory")
        assert scene.t_max is not None
        total = result.energy(np.linspace(0.0, scene.t_max, 401)).total
        made, left = max(made, float(total.max() / total[0]) - 1.0), min(left, total[-1] / total[0])
    return _of_energy(made if made > 1e-9 and made > 1.0 - left else left - 1.0)


def slide(spec: str) -> Cell:
    """Measure how far from 10.9 m a ball rests that slides and rolls."""
    result = play(make_engine(spec), shots.slide_to_rest())
    return _length(_off_at_rest(result))


def throw(spec: str) -> Cell:
    """Measure how far off the object ball is thrown where the balls rub with mu = 0.05."""
    # Between steps alone it is a late contact that turns the line, so that is taken away.
    engine = make_engine(_landed_if_it_can(spec))
    scene = shots.throw()
    x, y = play(engine, scene).final_state.velocities[0, 1, :2]
    wanted = 30.0 - math.degrees(math.atan(0.05))
    off = abs(math.degrees(math.atan2(-y, x)) - wanted)
    worth: Worth = "good" if off < 0.005 else "fair" if off < 0.1 else "bad"
    landed = getattr(engine.settings, "mode", "") == "landed"
    return Cell(off, f"{off:.2g}", worth, "landed" if landed else "")


def slow(spec: str) -> Cell:
    """Find the fastest elastic hit that comes out plastic."""
    engine = make_engine(spec)
    for speed in (2.1, 1.9, 1.0, 0.9, 0.5, 0.19, 0.09, 0.05, 0.019, 0.009, 0.005, 0.002, 0.001):
        speeds = play(engine, shots.head_on(speed)).final_state.velocities[0, :, 0] / speed
        if speeds[1] - speeds[0] < 0.5:
            worth: Worth = "fair" if speed < 0.02 else "bad"
            return Cell(speed, f"{speed:g}", worth)
    return Cell(0.0, "none", "good", "down to 1 mm/s")


def gas(spec: str) -> Cell:
    """Measure what 16 elastic balls make of their energy in 20 s."""
    engine = make_engine(spec)
    result = play(engine, shots.rack(0.0015, 20.0), record="trajectory")
    total = result.energy(np.linspace(0.0, 20.0, 2001)).total
    return _of_energy(float(total[-1] / total[0]) - 1.0)


def _of_energy(change: float) -> Cell:
    """Judge a change of the energy, over what there was."""
    if abs(change) < 1e-9:
        return Cell(0.0, "kept", "good")
    worth: Worth = "good" if abs(change) < 1e-4 else "fair" if abs(change) < 1e-2 else "bad"
    return Cell(float(change), f"{change:+.1e}", worth, "made" if change > 0.0 else "lost")


def to_a_millimetre(spec: str) -> Cell:
    """Measure the run time of a cut to rest that is right to 1 mm."""
    return _time_to(spec, 1e-3)


def to_a_micrometre(spec: str) -> Cell:
    """Measure the run time of a cut to rest that is right to 1 um."""
    return _time_to(spec, 1e-6)


def _time_to(spec: str, tolerance: float) -> Cell:
    """Return the least run time, native and landed, over a ladder of steps.

    A finer step takes longer: a ladder ends where it has taken longer than what is there already.
    """
    scene = shots.cut_to_rest()
    best, how = math.inf, ""

    def attempt(changed: str, name: str) -> tuple[float, float]:
        """Return how far off a configuration is and its run time, which counts where it's right."""
        nonlocal best, how
        engine = make_engine(changed)
        result = play(engine, scene)
        took = result.wall_time
        off = _off_at_rest(result)
        if off <= tolerance:
            took = min(took, play(engine, scene).wall_time)
            best, how = min((best, how), (took, name))
        return off, took

    ladder = [(dt, changed) for dt in LADDER if (changed := native(spec, dt)) is not None]
    landed = with_settings(spec, mode="landed", max_steps=MOST_STEPS)
    if landed is not None:
        attempt(landed, "landed")
    elif not ladder:
        attempt(spec, "as it is")
    for dt, changed in ladder:
        off, took = attempt(changed, f"steps of {dt:g} s")
        # Errors fall with the step at most: no step of the ladder may get there.
        if off <= tolerance or took > best or off * LADDER[-1] / dt > 10.0 * tolerance:
            break
    if not how:
        tried = f"with steps down to {LADDER[-1]:g} s" if ladder else "as it is"
        return Cell(None, "not reached", "bad", tried)
    return Cell(best, _seconds(best), "good" if best < 0.1 else "fair", how)


def run_time(spec: str) -> Cell:
    """Measure the run time of a break of 2 s."""
    engine, scene = make_engine(spec), shots.rack(0.001, 2.0)
    play(engine, scene)
    took = min(play(engine, scene).wall_time for _ in range(2))
    return Cell(took, _seconds(took), "good" if took < 2.0 else "fair")


def start(spec: str) -> Cell:
    """Measure the processor time that a fresh process takes for an engine's first shot."""
    took = start_time(spec)
    return Cell(took, _seconds(took), "good" if took < 3.0 else "fair")


def size(spec: str) -> Cell:
    """Measure what an engine adds to an installation."""
    found = installed_size(spec)
    if found is None:
        return Cell(None, "", "none", "nothing that is installed here brings it, by itself")
    megabytes = found / 1e6
    return Cell(megabytes, f"{megabytes:.0f}", "good" if megabytes < 100.0 else "fair")


def _off_at_rest(result: Result) -> float:
    """Return how far a ball at most rests from where it is proved to, along x or y [m]."""
    right = proved_end(result.scene).rest_positions
    return float(np.abs(result.rest_positions - right)[:, :2].max())


def _length(metres: float) -> Cell:
    kind = kind_of(metres)
    worth: Worth = {"nanometres": "good", "micrometres": "good", "millimetres": "fair"}.get(  # type: ignore[assignment]
        kind, "bad"
    )
    return Cell(metres, f"{metres:.1e}" if metres else "0", worth)


def _seconds(seconds: float) -> str:
    seconds = float(f"{seconds:.2g}")
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{1e6 * seconds:.3g} µs"


def _fault(one: Reported, spec: str) -> Cell:
    """Measure what an engine shows of a fault that was reported of one."""
    result = play(make_engine(spec), one.scene)
    off = one.off(result, proved_end(result.scene))
    worth: Worth = "good" if off <= one.right else "fair" if off <= one.fair else "bad"
    return Cell(off, f"{off:.1e}" if off else "0", worth)


QUESTIONS: Final[Mapping[str, Column]] = {
    "cut": Column(
        "single hit",
        "deg",
        "How far off a half-ball cut is, with steps of 1 ms",
        shots.half_ball(),
        cut,
        _stepped,
    ),
    "landed": Column(
        "landed",
        "deg",
        "The same where steps end on contacts",
        shots.half_ball(),
        landed_cut,
        _landed,
    ),
    "line": Column(
        "frozen line",
        "",
        "Which law a line of frozen balls plays",
        shots.frozen_line(),
        line,
        _as_it_is,
    ),
    "two": Column(
        "one into two",
        "",
        "Which law one ball into two plays",
        shots.one_into_two(),
        one_into_two,
        _as_it_is,
    ),
    "break": Column(
        "break",
        "",
        "What a break makes of its energy: the worst of three",
        shots.rack(),
        energy,
        _as_it_is,
    ),
    "slide": Column(
        "slide",
        "m",
        "How far from 10.9 m a ball rests that slides and rolls",
        shots.slide_to_rest(),
        slide,
        _as_it_is,
    ),
    "throw": Column(
        "throw",
        "deg",
        "How far off friction throws an object ball",
        shots.throw(),
        throw,
        _landed_if_it_can,
    ),
    "slow": Column(
        "plastic below",
        "m/s",
        "The fastest elastic hit that comes out plastic",
        shots.head_on(0.1),
        slow,
        _as_it_is,
    ),
    "gas": Column(
        "20 s gas",
        "",
        "What 16 elastic balls make of their energy in 20 s",
        shots.rack(0.0015, 20.0),
        gas,
    ),
    "mm": Column(
        "to 1 mm",
        "s",
        "Run time of a cut to rest that is right to 1 mm",
        shots.cut_to_rest(),
        to_a_millimetre,
    ),
    "um": Column("to 1 µm", "s", "The same to 1 µm", shots.cut_to_rest(), to_a_micrometre),
    "time": Column(
        "break time", "s", "Run time of 2 s of a break", shots.rack(0.001, 2.0), run_time
    ),
    "start": Column(
        "start",
        "s",
        "Processor time that a fresh process takes to load it and to play a first shot",
        shots.head_on(),
        start,
    ),
    "size": Column(
        "installed",
        "MB",
        "What it and all that it needs but numpy add to an installation",
        shots.head_on(),
        size,
    ),
}
"""What tells engines apart, in the order of the board."""

FAULTS: Final[Mapping[str, Column]] = {
    name: Column(one.title, "", one.said.rstrip("."), one.scene, partial(_fault, one), _as_it_is)
    for name, one in REPORTED.items()
}
"""What people reported of engines: how far off an engine's end of each scene is."""

COLUMNS: Final = {**QUESTIONS, **FAULTS}
"""All of them, by the names that `--column` takes."""
