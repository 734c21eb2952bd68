"""How like a real table an engine can be made to play: its best settings, and what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, Final, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from ghostball.model import (
    Ball,
    EngineFailedError,
    GhostballError,
    Physics,
    Scene,
    Table,
    UnsupportedSceneError,
)
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.measured.best import best_cloth, best_cushion, place_of
from ghostball.validation.measured.facts import Facts, Row, facts_of
from ghostball.validation.measured.rebounds import Play, ReboundError, rebounds
from ghostball.validation.measured.rolling import RollingWindows, rolling_windows
from ghostball.validation.measured.tracks import Surface, tracks_of

ANGLES: Final = (5.0, 45.0)
"""From the normal: what was measured hardly depends on it [degrees]."""


class Measured(BaseModel):
    """One figure that was measured, and what a model makes of it."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)

    at: float
    value: float
    error: Annotated[float, Field(gt=0.0)]
    played: float

    @property
    def errors_off(self) -> float:
        """How many standard errors of the measurement the model is above it."""
        return (self.played - self.value) / self.error


_FAILED = "it failed: "
"""How it begins why an engine that crashed, hung or raised has no figures."""


class Family(BaseModel):
    """Figures of one kind; or why an engine has none of them.

    `grades`: whether they count in what is said of the engine as a whole.
    """

    model_config = ConfigDict(frozen=True)

    name: str
    short: str
    title: str
    quantity: str
    unit: str
    against: str
    citation: str
    settings: dict[str, str | float] = {}
    figures: tuple[Measured, ...] = ()
    lacks: str = ""
    grades: bool = True

    @model_validator(mode="after")
    def _either(self) -> Self:
        if bool(self.figures) == bool(self.lacks):
            raise ValueError(
                f"family {self.name!r}: must either have `figures` or say what is lacking in "
                "`lacks`. Give one of them"
            )
        return self

    @property
    def failed(self) -> bool:
        """Whether there are none because the engine crashed, hung or raised."""
        return self.lacks.startswith(_FAILED)

    @property
    def typical(self) -> float:
        """The root of the mean square of how many standard errors the figures are off."""
        return float(np.sqrt(np.mean([one.errors_off**2 for one in self.figures])))

    @property
    def most(self) -> float:
        """How many standard errors the worst of them is off."""
        return max(abs(one.errors_off) for one in self.figures)


class Likeness(BaseModel):
    """What one engine makes of all that was measured."""

    model_config = ConfigDict(frozen=True)

    label: str
    families: tuple[Family, ...]

    @property
    def graded(self) -> tuple[Family, ...]:
        """The families that count in what is said of the engine as a whole."""
        return tuple(family for family in self.families if family.grades)

    @property
    def typical(self) -> float | None:
        """The largest of what its graded families are typically off; None where it has none."""
        return max((one.typical for one in self.graded if not one.lacks), default=None)


def likeness(label: str, engine: ReferenceEngine, play: Play) -> Likeness:
    """Return how like a real table an engine can be made to play.

    `play` plays a scene on it, and records the motion.
    """
    cushion = best_cushion(engine.name, engine.capabilities)
    rolling = _rolling("rolling-pool", engine, cushion, play)
    return Likeness(label=label, families=(*_cushions(engine, cushion, play), rolling))


def _cushions(
    engine: ReferenceEngine, cushion: dict[str, Any] | None, play: Play
) -> tuple[Family, Family]:
    facts = facts_of("cushion-carom")
    ratio = partial(_family, "cushion", facts)
    slope = partial(
        _family, "cushion-slope", facts, title=f"{facts.title}: how they change with speed"
    )
    if cushion is None:
        lacks = "it has no law of cushions that turns balls"
        return ratio(lacks=lacks), slope(lacks=lacks)
    changes = {**best_cloth("rolling-carom", engine.capabilities), **cushion}
    try:
        physics = Physics(preset="carom", **changes)
        figures = {
            degrees: [_measured(one.row, one.ratio) for one in rebounds(play, physics, degrees)]
            for degrees in ANGLES
        }
    except (UnsupportedSceneError, EngineFailedError, ReboundError) as error:
        lacks = _why(error)
        return ratio(lacks=lacks), slope(lacks=lacks)
    every = tuple(one for ones in figures.values() for one in ones)
    return (
        ratio(figures=every, settings=cushion),
        slope(
            figures=tuple(map(_slope, figures.values())),
            settings=cushion,
            quantity=f"slope of the {facts.quantity}, by weighted least squares",
            unit="s/m",
        ),
    )


def _measured(row: Row, played: float) -> Measured:
    """Return a figure beside what was played; its facts grade, so that it has an error."""
    assert row.error is not None
    return Measured(at=place_of(row), value=row.value, error=row.error, played=played)


def _slope(figures: list[Measured]) -> Measured:
    """Return the slope of measured and of played figures, by the same weighted least squares."""
    at, value, error, played = np.array(
        [(one.at, one.value, one.error, one.played) for one in figures]
    ).T
    slopes, covariance = np.polyfit(at, value, 1, w=1.0 / error, cov="unscaled")
    return Measured(
        at=float(np.mean(at)),
        value=float(slopes[0]),
        error=float(np.sqrt(covariance[0, 0])),
        played=float(np.polyfit(at, played, 1, w=1.0 / error)[0]),
    )


def _rolling(
    name: str, engine: ReferenceEngine, cushion: dict[str, Any] | None, play: Play
) -> Family:
    facts, cloth = facts_of(name), best_cloth(name, engine.capabilities)
    family = partial(_family, name, facts)
    physics = Physics(motion="sliding", **cloth, **(cushion or {}))
    try:
        figures = tuple(
            _measured(row, deceleration(play, physics, place_of(row))) for row in facts.rows
        )
    except (UnsupportedSceneError, EngineFailedError, ReboundError) as error:
        return family(lacks=_why(error))
    return family(figures=figures, settings=cloth)


def _why(error: GhostballError) -> str:
    """Return what an engine lacks, or did instead, without its name."""
    if isinstance(error, UnsupportedSceneError):
        return f"it has {'; '.join(error.features)}"
    return f"{_FAILED}{error.reason}" if isinstance(error, EngineFailedError) else str(error)


def deceleration(play: Play, physics: Physics, speed: float) -> float:
    """Return how a model slows a rolling ball that has a speed in the middle of a window [m/s^2].

    Raises `ReboundError` where it doesn't roll.
    """
    slowing = physics.rolling_friction * physics.gravity
    slowing += physics.rolling_friction_quadratic * speed**2
    start = speed + slowing * (_WINDOWS.after + _WINDOWS.length / 2.0)
    ball = Ball(id="cue", position=(1.0, 1.0), velocity=(start, 0.0))
    table = Table(length=_LONG, width=2.0)
    scene = Scene(name="rolls", table=table, physics=physics, balls=[ball], t_max=_PLAYED)
    found = rolling_windows(
        tracks_of(play(scene)), Surface(table.length, table.width, ball.radius), _WINDOWS
    )
    if not found:
        raise ReboundError(f"a ball that begins to roll at {start:.3g} m/s doesn't roll")
    return found[0].deceleration


def _family(
    name: str,
    facts: Facts,
    *,
    title: str = "",
    quantity: str = "",
    unit: str = "",
    settings: Mapping[str, str | float] | None = None,
    figures: tuple[Measured, ...] = (),
    lacks: str = "",
) -> Family:
    return Family(
        name=name,
        short=_SHORT[name],
        title=title or facts.title,
        quantity=quantity or facts.quantity,
        unit=unit or facts.unit,
        against=facts.against,
        citation=facts.citation,
        settings=dict(settings or {}),
        figures=figures,
        lacks=lacks,
    )


_SHORT = {
    "cushion": "rebound",
    "cushion-slope": "rebound against speed",
    "rolling-pool": "rolling",
}
_WINDOWS = RollingWindows(slowest=0.0)
_LONG = 10.0  # table [m]
_PLAYED = 2.0  # [s]
