"""The record of a case: its results, its checks and its motion.

The store writes these records, and reports are made only from them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict

from ghostball.model import Events, GhostballError, Scene, SceneError, Status
from ghostball.model.scene.fields import SceneName
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.results.fields import Definition, StoredArray, check_shape
from ghostball.validation.results.quantities import scaled

CLOSED_FORM: Final = "closed form"
CERTIFIED: Final = "certified"
INTEGRATION: Final = "integration, not certified (estimated error below 1e-20 m)"
OUR_ENGINE: Final = "Ghostball's engine (not independent)"

INDEPENDENT: Final = frozenset({CLOSED_FORM, CERTIFIED, INTEGRATION})
"""Kinds of reference results that don't depend on Ghostball's engine."""

CaseOutcome = Literal["ran", "not-representable", "unavailable", "failed"]
LimitKind = Literal["at_most", "at_least", "equals"]

Fault = Literal["", "engine", "ghostball"]
"""Who is at fault if a case failed; "" if it didn't fail.

"ghostball": a reference result that could not be computed, a metric that raised, and exceptions of
Ghostball's engine. "engine": anything that another engine raises or returns, a crash, and the time
limit.
"""

AccuracyKind = Literal[
    "exact", "nanometres", "micrometres", "millimetres", "centimetres", "another shot", "broken"
]
"""Accuracy classes, from the best to the worst; see `validation.checks.accuracy`."""

ACCURACY_KINDS: Final[tuple[str, ...]] = get_args(AccuracyKind)
"""The classes in this order: the value of the metric `accuracy` is an index into it."""

BrokenBy = Literal["stopped", "not finite", "energy", "overlap", "jump"]
"""Why a run is unphysical: it stopped early, a number isn't finite, energy increased, balls overlap
or pass through each other, or velocities jump without a contact.
"""

_COMPARISONS: Final[Mapping[LimitKind, str]] = {
    "at_most": "at most",
    "at_least": "at least",
    "equals": "exactly",
}


def scene_from(definition: Mapping[str, Any], name: str) -> Scene:
    """Return the scene with the stored definition.

    Raises `GhostballError` if the definition is damaged by an edit: a scene is checked before it
    runs.
    """
    try:
        return Scene.model_validate(definition)
    except SceneError as error:
        raise GhostballError(
            f'the stored results of scene "{name}" are damaged: {error} Run them again'
        ) from None


def status_name(status: Status) -> str:
    """Return the word for a `Status` in records, such as "t-max"."""
    return status.name.lower().replace("_", "-")


COMPLETE_STATUSES = frozenset(status_name(status) for status in Status if status.complete)
"""Statuses of runs that finished by themselves, as records name them."""


@dataclass(frozen=True)
class Check:
    """One metric against its limit.

    `metric`, `unit`: name and unit; see `validation.checks.metrics.METRICS`.
    `value`: None if it could not be computed; `note` says why.
    `passed`: None for "reference": the value compares Ghostball's engine with itself and proves
        nothing.
    `reason`: why the limit has this value, from the criteria of the scene.
    `note`: why there is no value or no verdict; else "".
    """

    metric: str
    value: int | float | None
    limit_kind: LimitKind
    limit: int | float
    unit: str
    passed: bool | None
    reason: str
    note: str = ""

    @property
    def sentence(self) -> str:
        """The limit and the value in one sentence, with units and enough digits to differ."""
        must = f"{self.metric} must be {_COMPARISONS[self.limit_kind]}"
        limit = number_with_unit(self.limit, self.unit, DIGITS[0])
        if self.value is None:
            return f"{must} {limit}, but has no value: {self.note}"
        for digits in DIGITS:
            limit, value = (
                number_with_unit(x, self.unit, digits) for x in (self.limit, self.value)
            )
            if limit != value:
                break
        found = f"{must} {limit}, got {value}"
        return f"{found}: {self.note}" if self.note and self.passed is not None else found


DIGITS: Final = (4, 6, 17)
"""Significant digits of a limit and a value; more if fewer would show the two as equal."""


def number_with_unit(value: float | int | None, unit: str, digits: int = 6) -> str:
    """Return a value with its unit for messages; a number with unit "1" stands alone.

    For unit "class", return the name of the accuracy class.
    """
    if unit == "class" and value is not None:
        return ACCURACY_KINDS[int(value)]
    if unit in ("m", "s") and value is not None:
        return scaled(value, unit, digits)
    number = "nothing" if value is None else f"{value:.{digits}g}"
    if isinstance(value, int):
        number = str(value)
    return number if unit == "1" else f"{number} {unit}"


@dataclass(frozen=True)
class Accuracy:
    """The accuracy class of a run, with its numbers.

    `error` [m]: largest position error of a ball; None for wrong collisions.
    `at` [s]: for wrong collisions, the time of the first wrong collision, or None if a missing
        collision has no known time. Otherwise the time at which positions were compared, if that
        isn't the end: after it, rounding alone would change the collisions.
    `agree`, `of`: for wrong collisions, the number of right collisions, and of reference
        collisions.
    `amount`: for unphysical runs, the energy gain or the energy in velocity jumps, divided by the
        initial energy; or the largest overlap [m].
    """

    kind: AccuracyKind
    error: float | None = None
    at: float | None = None
    agree: int | None = None
    of: int | None = None
    cause: BrokenBy | None = None
    amount: float | None = None

    @property
    def sentence(self) -> str:
        """The class and its numbers in plain text."""
        at = "" if self.at is None else f" at {number_with_unit(self.at, 's')}"
        if self.kind == "broken":
            much = "" if self.amount is None else f" ({self.amount:.3g})"
            cause = "velocities jump without a contact" if self.cause == "jump" else self.cause
            return f"unphysical: {cause}{much}"
        if self.kind == "another shot":
            return (
                f"wrong collisions: the first {self.agree} of {self.of} are right; first wrong "
                f"collision{at}"
            )
        if self.kind == "exact":
            return f"exact: position error no larger than rounding{at}"
        return f"{self.kind}: position error {number_with_unit(self.error, 'm')}{at}"


@dataclass(frozen=True, eq=False)
class RelatedRun:
    """A run, and the run of a related shot mapped back to the first shot, at one time.

    `t` [s]: time of the largest difference, in units of the allowed one.
    `first`, `second` (n, 3) float64 [m]: positions of all balls; nan for a ball that isn't there.
    """

    t: float
    first: StoredArray
    second: StoredArray


@dataclass(frozen=True, eq=False)
class CaseRecord:
    """The result of one scene on one engine.

    `scene`, `title`, `tags`: from the scene.
    `definition`: the whole scene as plain values; `load_scene` returns it as a `Scene`.
    `label`: the engine with its settings, as the user wrote it, such as
        "pymunk:contact_steps=exact".
    `engine`: its name alone, "pymunk".
    `settings`: all its settings.
    `status`: how the simulation ended: "rest", "t-max", ...; None if it did not run.
    `reason`: why it did not run, failed, or stopped early; else "".
    `traceback`: traceback of a failure; else "".
    `fault`: who is at fault for a failure.
    `printed`: the output of the engine; else "".
    `approximations`: features of this scene that the engine supports only approximately, one
        sentence each.
    `accuracy`: None if there is no reference result, or if the run itself is the reference.
    `truth_positions` (n, 3) float64 [m] or None: reference rest positions.
    `horizon` [s]: time up to which this engine can be expected to simulate the shot
        (`Truth.horizon_of`), if that is before the end; then the end isn't judged.
    `shot_horizon` [s]: time up to which rounding leaves the shot predictable; None: to its end, or
        unknown.
    `truth_rest_time` [s]: reference rest time.
    `truth_counts`: reference collision counts by kind.
    `rest_positions` (n, 3) float64 [m] or None: nan for numbers that aren't finite.
    `ball_errors` (n,) float64 [m] or None: distance of each ball from `truth_positions`.
    `rest_time` [s].
    `bits`: hash of events and rest positions, to the bit; "" if it did not run.
    `collision_counts`: by kind: "ball-ball", "ball-cushion".
    `energy_initial`, `energy_final` [J].
    `work`: machine-independent counters.
    `wall_time`, `engine_time` [s]: as in `Result`.
    `metrics`: by name; None if a metric can't be computed, and `notes` says why.
    `notes`: by metric.
    `left_out`: metrics with limits that weren't judged, because the run didn't ask for these
        metrics.
    `excused`: why the limits common to all engines don't apply to this one; else "".
    `not_asked`: the metrics of the limits that `excused` suspends.
    `unstated`: whether the engine states no resolution here, so that no common limit applies to its
        final state.
    `claim`: the claim of the engine in the scene (`Claim` in `validation.checks.criterion`); "" if
        it did not run.
    `measured`: date and time of the run in UTC, ISO 8601; `wall_time` was measured then.
    `reused`: whether an earlier run made this record, and this run reused it unchanged.
    `related`: both runs of each measured relation, by its name.
    `varied_from`: the scene of which this one is a perturbed initial state (`suite.ensemble`); else
        "".
    """

    scene: SceneName
    title: str
    tags: tuple[str, ...]
    definition: Definition
    label: str
    engine: str
    outcome: CaseOutcome
    settings: dict[str, Any] = field(default_factory=dict)
    status: str | None = None
    reason: str = ""
    traceback: str = ""
    fault: Fault = ""
    printed: str = ""
    approximations: tuple[str, ...] = ()
    accuracy: Accuracy | None = None
    truth: str | None = None
    truth_positions: StoredArray | None = None
    truth_rest_time: float | None = None
    horizon: float | None = None
    shot_horizon: float | None = None
    truth_counts: dict[str, int] | None = None
    rest_positions: StoredArray | None = None
    ball_errors: StoredArray | None = None
    rest_time: float | None = None
    bits: str = ""
    collision_counts: dict[str, int] = field(default_factory=dict)
    energy_initial: float | None = None
    energy_final: float | None = None
    work: dict[str, int] = field(default_factory=dict)
    wall_time: float | None = None
    engine_time: float | None = None
    metrics: dict[str, int | float | None] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    checks: tuple[Check, ...] = ()
    left_out: tuple[str, ...] = ()
    excused: str = ""
    not_asked: tuple[str, ...] = ()
    unstated: bool = False
    claim: Literal["", "rounding", "exact", "less"] = ""
    measured: str = ""
    reused: bool = False
    related: dict[str, RelatedRun] = field(default_factory=dict)
    varied_from: SceneName | Literal[""] = ""

    __pydantic_config__ = ConfigDict(extra="forbid", arbitrary_types_allowed=True)

    def __post_init__(self) -> None:
        """Refuse arrays with a wrong number of balls, and an invalid run time."""
        n = len(self.definition.get("balls", ()))
        check_shape("truth_positions", self.truth_positions, (n, 3))
        check_shape("rest_positions", self.rest_positions, (n, 3))
        check_shape("ball_errors", self.ball_errors, (n,))
        for name, one in self.related.items():
            check_shape(f"related.{name}.first", one.first, (n, 3))
            check_shape(f"related.{name}.second", one.second, (n, 3))
        wall_time = self.metrics.get("wall_time")
        if wall_time is not None and not 0.0 <= wall_time < math.inf:
            raise ValueError(f"`metrics.wall_time` must be seconds, at least 0, got {wall_time}")

    @property
    def is_exact(self) -> bool:
        """Whether the final positions are right to rounding."""
        found = self.accuracy
        return found is not None and found.kind == "exact" and found.at is None

    @property
    def is_own_measure(self) -> bool:
        """Whether Ghostball's engine is compared with itself, which proves nothing.

        If Ghostball's engine doesn't support the scene, it isn't the reference.
        """
        ours = self.outcome == "ran" and self.engine == OURS
        return ours and self.truth not in INDEPENDENT

    @property
    def passed(self) -> bool | None:
        """Whether every check passed; None if there is nothing to judge."""
        verdicts = [check.passed for check in self.checks if check.passed is not None]
        return all(verdicts) if verdicts else None

    @property
    def broken(self) -> tuple[Check, ...]:
        """The checks that failed."""
        return tuple(check for check in self.checks if check.passed is False)

    def load_scene(self) -> Scene:
        """Return the scene that was run.

        Raises `GhostballError` if the definition is damaged.
        """
        return scene_from(self.definition, self.scene)


@dataclass(frozen=True, eq=False)
class Motion:
    """Events and sampled motion of one case.

    `events`, a structured array (`model.EVENT_DTYPE`), in order of time.
    `times` (k,) float64 [s]: a uniform grid united with the event times and, for curved paths,
        enough further times to draw them; increasing.
    `positions`, `velocities`, `angular_velocities` (k, n, 3) float64 [m], [m/s], [rad/s].
    `energy_translation`, `energy_rotation`, `energy_height` (k,) float64 [J].
    `phases` (k, n) int8 or None: `model.trajectory.Phase` of each ball; None for an engine that
        records frames, which have no phases, and for motions stored by a version without phases.
    """

    events: Events
    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    angular_velocities: NDArray[np.float64]
    energy_translation: NDArray[np.float64]
    energy_rotation: NDArray[np.float64]
    energy_height: NDArray[np.float64]
    phases: NDArray[np.int8] | None = None

    @property
    def energy(self) -> NDArray[np.float64]:
        """Total energy, (k,) float64 [J]."""
        return self.energy_translation + self.energy_rotation + self.energy_height
