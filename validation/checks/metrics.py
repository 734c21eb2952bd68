"""What is measured of a run, each metric with its unit and meaning.

A metric that can't be computed is None with the reason beside it, never 0.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Result, first_energy
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import ReferenceEngine, Resolution
from ghostball.validation.checks.energy_curve import conserves_energy
from ghostball.validation.checks.energy_gain import largest_gain
from ghostball.validation.checks.metric_table import METRICS, USUAL
from ghostball.validation.checks.proof_metrics import (
    PROOF_METRICS,
    Compute,
    NotMeasuredError,
    RunIncompleteError,
    differences_of,
    early_path_error,
    event_time_error,
    known,
    phase_time_error,
    require_end,
)
from ghostball.validation.checks.relations import RELATIONS
from ghostball.validation.grading.event_logs import Agreement, compare_collisions
from ghostball.validation.grading.tolerances import EPS, TOLERANCE
from ghostball.validation.results.records import ACCURACY_KINDS, Accuracy
from ghostball.validation.runs.sampling import (
    energy_series,
    events_of,
    largest_cushion_overlap,
    largest_overlap,
    momentum_series,
)
from ghostball.validation.truth.scene_truth import Truth

Value = int | float | None


_REST_ERRORS = ("rest_error_max", "rest_error_rms", "rest_error_ulps")
"""Metrics that are made of the balls' errors."""


@dataclass
class Measured:
    """Metrics of one case.

    `values`: by name, one for each that was asked for, in the order of `METRICS`.
    `notes`: why a value is None.
    `said`: more of a value than the value.
    `incomplete`: metrics that have no good value because of what the run did: it ended early, isn't
        finite, or is broken.
    `unpredictable`: metrics without a value since they are of the end, which the engine can't
        predict.
    `ball_errors` (n,) float64 [m] or None: distance of each ball from where it should end; None
        where no metric of them has a value.
    """

    values: dict[str, Value] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    said: dict[str, str] = field(default_factory=dict)
    ball_errors: FloatArray | None = None
    incomplete: set[str] = field(default_factory=set)
    unpredictable: set[str] = field(default_factory=set)

    def add_class(self, found: Accuracy | None, why: str = "", *, compared: bool = True) -> None:
        """Add the metric `accuracy`, where there is a class that says how right the end is.

        Past the horizon that is left to rounding there is none, unless the run is farther off by
        then than an exact engine may be, or is another shot. `why` says more of what is broken.
        `compared` says whether the run has a reference.
        """
        name = "accuracy"
        self.values[name] = None
        if found is None and compared:
            self.notes[name] = "past the horizon: rounding alone may change the collisions before"
        elif found is None:
            self.notes[name] = "there is nothing to compare the run with"
        elif found.at is not None and found.error is not None and found.error <= TOLERANCE:
            self.notes[name] = f"only up to t = {found.at:.3g} s the shot can be predicted"
        else:
            self.values[name] = ACCURACY_KINDS.index(found.kind)
            more = f": {why}" if why else ""
            self.said[name] = found.sentence.removeprefix(f"{found.kind}: ") + more
        if found is not None and found.kind == "broken":
            self.incomplete.add(name)


def measure(
    result: Result,
    truth: Truth,
    metrics: Collection[str] | None = None,
    *,
    horizon: float = math.inf,
    resolution: Resolution = 0.0,
    include_past_horizon: Collection[str] = (),
    engine: ReferenceEngine | None = None,
) -> Measured:
    """Measure a run recorded with `record="trajectory"` against the truth of its scene.

    `metrics`: names of those that are computed; left out: all that aren't measured on demand.
    `horizon` [s]: until when the engine can be expected to play this shot: `Truth.horizon_of`. What
        is an error of the end of a shot has no value where that lies later; energies are compared
        up to there.
    `resolution` [m]: of the engine: `reference_adapters.base.resolution_of`.
    `include_past_horizon`: metrics that have a value all the same.
    `engine`: plays the other shots that relations need; without it they have no value.
    """
    measured = Measured()
    wanted = frozenset(USUAL if metrics is None else metrics)
    beyond = truth.rest_time is not None and horizon < truth.rest_time
    if resolution in (0.0, "proved"):
        # An engine that errs by rounding alone is graded as exact even if it records only frames.
        truth = replace(truth, graded_steps=truth.graded)
    computes = _computes(horizon, resolution, engine)
    for name in METRICS:
        if name not in computes or name not in wanted:
            continue
        try:
            if beyond and METRICS[name].to_the_end and name not in include_past_horizon:
                measured.unpredictable.add(name)
                raise NotMeasuredError(past_horizon(horizon))
            value = computes[name](result, truth)
        except NotMeasuredError as why:
            measured.values[name], measured.notes[name] = None, str(why)
            if isinstance(why, RunIncompleteError):
                measured.incomplete.add(name)
            continue
        if not np.isfinite(value):
            measured.values[name] = None
            measured.notes[name] = f"not finite: {value}"
            measured.incomplete.add(name)
            continue
        measured.values[name] = value
    if any(measured.values.get(name) is not None for name in _REST_ERRORS):
        measured.ball_errors = ball_errors(result, truth)
    return measured


def past_horizon(horizon: float) -> str:
    """Return why nothing is said of the end of a shot that can't be predicted to its end."""
    return (
        f"unpredictable: from t = {horizon:.3g} s on, errors of this engine's size may lead the "
        "shot onto another path"
    )


def ball_errors(result: Result, truth: Truth) -> FloatArray:
    """Return each ball's distance from where it should end, (n,) float64 [m].

    Raises `NotMeasuredError` where the run did not reach its end, or there is no truth.
    """
    require_end(result)
    right = known(truth.rest_positions, truth, "rest")
    # The first difference of near-equal doubles is exact; the low part completes the truth.
    difference = (result.rest_positions - right) - truth.rest_positions_low
    distances: FloatArray = np.linalg.norm(difference, axis=1)
    return distances


def _rest_error_ulps(result: Result, truth: Truth) -> float:
    conditioning = known(truth.conditioning, truth, "conditioning")
    return float(np.max(ball_errors(result, truth) / (EPS * conditioning)))


def _rest_time_error(result: Result, truth: Truth) -> float:
    require_end(result)
    return abs((result.rest_time - known(truth.rest_time, truth, "time")) - truth.rest_time_low)


def _rest_time_error_ulps(result: Result, truth: Truth) -> float:
    conditioning = known(truth.rest_time_conditioning, truth, "conditioning")
    if conditioning == 0.0:
        raise NotMeasuredError("no ball moves in this scene: its rest time is 0 by definition")
    return _rest_time_error(result, truth) / (EPS * conditioning)


def _count(kind: EventKind) -> Compute:
    return lambda result, _: int(result.collision_counts[kind.label])


def _count_error(kind: EventKind) -> Compute:
    def error(result: Result, truth: Truth) -> int:
        require_end(result)
        right = known(truth.collision_counts, truth, "events")[kind.label]
        return abs(int(result.collision_counts[kind.label]) - right)

    return error


def _compared(result: Result, truth: Truth) -> Agreement:
    """Compare the collisions with the true ones."""
    collisions = known(truth.collisions, truth, "events")
    return compare_collisions(collisions, truth.collision_times, events_of(result))


def _first_divergence_time(result: Result, truth: Truth) -> float:
    require_end(result)
    parts_at = _compared(result, truth).parts_at(timed=bool(len(truth.collision_times)))
    if parts_at is None:
        raise NotMeasuredError("a collision is missing; the closed form does not say when it comes")
    if math.isinf(parts_at):
        raise NotMeasuredError("never: the sequences agree to the end")
    return parts_at


def _energy_difference_max(result: Result, truth: Truth, horizon: float) -> float:
    _, differences = differences_of(result, truth, horizon)
    return float(np.max(_finite(differences))) / _initial(result)


def _energy_difference_time(result: Result, truth: Truth, horizon: float) -> float:
    times, differences = differences_of(result, truth, horizon)
    largest = int(np.argmax(_finite(differences)))
    if differences[largest] == 0.0:
        raise NotMeasuredError("the energy equals the reference at every instant compared")
    return float(times[largest])


def _energy_drift(result: Result, _: Truth) -> float:
    if not conserves_energy(result.scene):
        raise NotMeasuredError("energy isn't conserved in this scene")
    energy = _finite(energy_series(result))
    return float(np.max(np.abs(energy - energy[0]))) / _initial(result)


def _energy_rise(result: Result, truth: Truth, resolution: Resolution) -> float:
    _finite(energy_series(result))
    proof = truth.certificate
    pressed = proof is not None and proof.ending == "sustained contact"
    gain = largest_gain(result, resolution, pressed=pressed)
    if gain > 0.0 and first_energy(result.scene) == 0.0:
        return math.inf  # made of nothing
    return gain / _initial(result)


def _overlap_max(result: Result, _: Truth) -> float:
    if len(result.scene.balls) == 1:
        raise NotMeasuredError("there is one ball only")
    return largest_overlap(result)


def _cushion_overlap_max(result: Result, _: Truth) -> float:
    table = result.scene.table
    if table is None or not table.has_cushions:
        raise NotMeasuredError("there are no cushions")
    return largest_cushion_overlap(result)


def _momentum_drift(result: Result, _: Truth) -> float:
    momenta = momentum_series(result)
    largest = float(np.max(np.sum(np.linalg.norm(momenta, axis=2), axis=1)))
    if largest == 0.0:
        raise NotMeasuredError("nothing moves: there is no momentum to compare with")
    total = np.sum(momenta, axis=1)
    return float(np.max(np.abs(total - total[0]))) / largest


def _unsolved(result: Result, _: Truth) -> int:
    counts = [count for name, count in result.work.items() if name.startswith("unsolved")]
    if not counts:
        raise NotMeasuredError("the engine doesn't count what it left unsolved")
    return int(sum(counts))


def _contact_steps(result: Result, _: Truth) -> int:
    if "contact_steps" not in result.work:
        raise NotMeasuredError("the engine doesn't count contact steps")
    return int(result.work["contact_steps"])


def _pocketed_count(result: Result, _: Truth) -> int:
    return int(np.count_nonzero(events_of(result)["kind"] == EventKind.POCKETED))


def _related(name: str, engine: ReferenceEngine | None) -> Compute:
    def value(result: Result, _: Truth) -> float:
        if engine is None:
            raise NotMeasuredError("this metric needs an engine that simulates a second shot")
        require_end(result)
        return RELATIONS[name](engine, result)

    return value


_COMPUTE: dict[str, Compute] = {
    "rest_error_max": lambda result, truth: float(np.max(ball_errors(result, truth))),
    "rest_error_rms": lambda result, truth: float(
        np.sqrt(np.mean(ball_errors(result, truth) ** 2))
    ),
    "rest_error_ulps": _rest_error_ulps,
    "rest_time_error": _rest_time_error,
    "rest_time_error_ulps": _rest_time_error_ulps,
    "ball_ball_count": _count(EventKind.BALL_BALL),
    "ball_cushion_count": _count(EventKind.BALL_CUSHION),
    "collision_count": lambda result, _: sum(
        int(result.collision_counts[kind.label]) for kind in COLLISION_KINDS
    ),
    "ball_ball_count_error": _count_error(EventKind.BALL_BALL),
    "ball_cushion_count_error": _count_error(EventKind.BALL_CUSHION),
    "matching_events": lambda result, truth: _compared(result, truth).leading,
    "first_divergence_time": _first_divergence_time,
    "energy_drift": _energy_drift,
    "overlap_max": _overlap_max,
    "cushion_overlap_max": _cushion_overlap_max,
    "momentum_drift": _momentum_drift,
    "pocketed_count": _pocketed_count,
    "event_count": lambda result, _: len(events_of(result)),
    "contact_steps": _contact_steps,
    "unsolved": _unsolved,
    "wall_time": lambda result, _: result.wall_time,
}


def _computes(
    horizon: float, resolution: Resolution, engine: ReferenceEngine | None
) -> dict[str, Compute]:
    """Return what computes each metric, for an engine with this horizon [s] and resolution [m]."""
    return {
        **_COMPUTE,
        **PROOF_METRICS,
        **{name: _related(name, engine) for name in RELATIONS},
        "energy_rise": partial(_energy_rise, resolution=resolution),
        "energy_difference_max": partial(_energy_difference_max, horizon=horizon),
        "energy_difference_time": partial(_energy_difference_time, horizon=horizon),
        "event_time_error": partial(event_time_error, horizon=horizon),
        "early_path_error": partial(early_path_error, resolution=resolution),
        "phase_time_error": partial(phase_time_error, horizon=horizon, resolution=resolution),
    }


def _finite(energy: FloatArray) -> FloatArray:
    if not np.all(np.isfinite(energy)):
        raise RunIncompleteError("the energy of the engine's motion is not finite")
    return energy


def _initial(result: Result) -> float:
    first = first_energy(result.scene)
    if first == 0.0:
        raise NotMeasuredError("nothing moves at the start: there is no energy to compare with")
    return first
