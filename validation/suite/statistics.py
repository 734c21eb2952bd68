"""Statistical verdicts on shots that are too chaotic to be compared one by one.

Each scene is run from perturbed initial states (`suite.ensemble`), as cases of the same run. For
each quantity of the final state, the values on an engine and those on Ghostball's engine are two
samples. Two-sample tests decide whether both can come from one distribution. This compares two
codes; it doesn't compare a code with a reference result.

- Numbers: the test of Kolmogorov and Smirnov, which assumes no distribution.
- Rest positions of all balls together: the energy distance (Szekely and Rizzo 2004), with the mean
  distance over all balls as the distance of two runs, and a permutation test.

All p values of a scene are adjusted together by Holm's method (1979), so that an engine with the
right distributions is called different in any of them with a probability of at most `FALSE_ALARMS`.
All engines run the same perturbed states. If their single results agree, the probability is lower.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Final

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.checks.motion_metrics import ENERGY_TIMES
from ghostball.validation.checks.verdict import is_unfinished
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Results

FALSE_ALARMS: Final = 1e-3
"""Largest probability that an engine with the right distributions is called different."""

POWER: Final = 0.9
"""Probability with which a difference of the size `visible` is found."""

_PERMUTATIONS: Final = 19_999
"""Number of permutations of the rest positions: the smallest p value is 1 in 20 000."""

_CHUNK: Final = 500
"""Number of permutations that are made at once."""

_TRIALS: Final = 60
"""Number of pairs of samples with which the size of a visible difference is found."""

_MISSES: Final = round((1.0 - POWER) * _TRIALS)
"""Number of these pairs in which a visible difference may be missed."""

_HALVINGS: Final = 12
"""Number of bisections for the size of a visible difference."""

REST_POSITIONS: Final = "rest positions [m]"


def _metric(name: str, case: CaseRecord) -> float:
    value = case.metrics.get(name)
    return math.inf if value is None else float(value)


QUANTITIES: Final[Mapping[str, Callable[[CaseRecord], float]]] = {
    "ball-ball collisions": lambda case: float(case.collision_counts["ball-ball"]),
    "ball-cushion collisions": lambda case: float(case.collision_counts["ball-cushion"]),
    "rest time [s]": lambda case: case.rest_time or 0.0,
    "pocketed balls": partial(_metric, "pocketed_count"),
    **{
        f"time until {share:.0%} of the energy is left [s]": partial(_metric, name)
        for name, share in ENERGY_TIMES.items()
    },
}
"""Quantities of a run that are numbers, with their units; inf if a run doesn't reach a value."""


@dataclass(frozen=True)
class QuantityVerdict:
    """One quantity on an engine and on Ghostball's engine.

    `mean`, `deviation`: of the finite values on the engine; nan for rest positions.
    `known`: the mean on Ghostball's engine; nan for rest positions.
    `by`: difference of the means; for rest positions, the largest distance between the mean rest
        positions of a ball [m].
    `p`: probability of a difference like this by chance, adjusted for all quantities.
    `visible`: difference that would be found with the probability `POWER`; None if these runs can't
        show any difference.
    """

    name: str
    mean: float
    deviation: float
    known: float
    by: float
    p: float
    visible: float | None

    @property
    def differs(self) -> bool:
        """Whether chance doesn't explain the difference."""
        return self.p < FALSE_ALARMS


@dataclass(frozen=True, eq=False)
class EnsembleVerdict:
    """The verdict on one scene on one engine, from perturbed initial states.

    `planned`, `ended`, `compared`: number of runs planned, finished, and finished on Ghostball's
        engine.
    `broken`: number of finished runs that fail a common limit.
    `reasons`: why the remaining runs did not finish, without duplicates.
    `exact`: whether the engine claims to be exact in this scene; a difference is then a failure.
    `position_spread` [m]: distance of a ball from its mean rest position, rms over all balls.
    `quantities`: empty for Ghostball's engine, and if there is nothing to compare.
    """

    scene: str
    label: str
    planned: int
    ended: int
    compared: int
    broken: int
    reasons: tuple[str, ...]
    exact: bool
    position_spread: float | None
    quantities: tuple[QuantityVerdict, ...]

    @property
    def different(self) -> tuple[QuantityVerdict, ...]:
        """The quantities that differ, the smallest p value first."""
        return tuple(sorted((one for one in self.quantities if one.differs), key=lambda q: q.p))

    @property
    def failed(self) -> bool:
        """Whether the engine claims to be exact, and differs."""
        return self.exact and bool(self.different)

    @property
    def is_blind(self) -> bool:
        """Whether so few runs were compared that no difference could be found."""
        count = len(self.quantities)
        return count > 0 and min(self.ended, self.compared) < runs_needed(count)


def runs_needed(quantities: int) -> int:
    """Return the number of runs with which a difference in one of several quantities shows."""
    level = FALSE_ALARMS / quantities
    return next(n for n in range(2, 1000) if _least_distance(n, level) is not None)


@lru_cache(maxsize=1)  # the terminal, the page and the exit status need them
def ensemble_verdicts(results: Results) -> tuple[EnsembleVerdict, ...]:
    """Return the verdict on each scene with perturbed initial states, on each engine."""
    return tuple(_verdicts(results))


def _verdicts(results: Results) -> Iterator[EnsembleVerdict]:
    cases: dict[tuple[str, str], list[CaseRecord]] = {}
    for case in results.varied:
        cases.setdefault((case.varied_from, case.label), []).append(case)
    for scene in results.scene_names:
        ours = _ended(cases.get((scene, OURS), []))
        for label in results.labels:
            if (scene, label) in cases:
                yield _verdict(scene, label, cases[scene, label], ours)


def _ended(cases: Sequence[CaseRecord]) -> list[CaseRecord]:
    return [case for case in cases if case.outcome == "ran" and not is_unfinished(case)]


def _verdict(
    scene: str, label: str, cases: Sequence[CaseRecord], ours: Sequence[CaseRecord]
) -> EnsembleVerdict:
    ended = _ended(cases)
    spread: float | None = None
    quantities: tuple[QuantityVerdict, ...] = ()
    if len(ended) >= 2:
        rest = _rest(ended)
        spread = float(np.sqrt(np.mean(np.sum((rest - rest.mean(axis=0)) ** 2, axis=2))))
        if label != OURS and len(ours) >= 2:
            quantities = compare_samples(ended, ours)
    return EnsembleVerdict(
        scene,
        label,
        len(cases),
        len(ended),
        len(ours),
        sum(case.passed is False for case in ended),
        tuple(dict.fromkeys(case.reason for case in cases if case not in ended)),
        any(case.claim in ("rounding", "exact") for case in ended),
        spread,
        quantities,
    )


def compare_samples(
    ended: Sequence[CaseRecord], ours: Sequence[CaseRecord], *, sizes: bool = True
) -> tuple[QuantityVerdict, ...]:
    """Compare the finished runs of an engine with those of Ghostball's engine.

    `sizes`: whether the sizes of visible differences are computed.
    """
    samples = {
        name: (np.array([of(one) for one in ended]), np.array([of(one) for one in ours]))
        for name, of in QUANTITIES.items()
    }
    # A quantity with one value in all runs, such as no pocketed ball, can't differ.
    samples = {name: pair for name, pair in samples.items() if len({*map(float, np.r_[pair])}) > 1}
    level = FALSE_ALARMS / (len(samples) + 1) if sizes else 0.0
    tests = {name: _numbers(name, *pair, level) for name, pair in samples.items()}
    tests[REST_POSITIONS] = _places(_rest(ended), _rest(ours), level)
    adjusted = holm([one.p for one in tests.values()])
    return tuple(
        QuantityVerdict(**(vars(one) | {"p": p}))
        for one, p in zip(tests.values(), adjusted, strict=True)
    )


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p values adjusted by Holm's method, to limit the probability of any false alarm."""
    order = sorted(range(len(p_values)), key=lambda k: p_values[k])
    adjusted, largest = [1.0] * len(p_values), 0.0
    for rank, k in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[k]))
        adjusted[k] = largest
    return adjusted


def _rest(cases: Sequence[CaseRecord]) -> FloatArray:
    """Return x and y of the rest positions, (runs, n, 2) [m]."""
    places: FloatArray = np.array([case.rest_positions for case in cases])[:, :, :2]
    return places


def _numbers(name: str, one: FloatArray, known: FloatArray, level: float) -> QuantityVerdict:
    p = _p_value(one, known)
    finite, right = one[np.isfinite(one)], known[np.isfinite(known)]
    mean = float(np.mean(finite)) if len(finite) else math.inf
    true = float(np.mean(right)) if len(right) else math.inf
    deviation = float(np.std(finite, ddof=1)) if len(finite) > 1 else 0.0
    least = _least_distance(min(len(one), len(known)), level)
    visible = None
    if least is not None and len(right) == len(known):
        visible = _visible(len(one), right, _step_test(least))
    by = 0.0 if mean == true else mean - true
    return QuantityVerdict(name, mean, deviation, true, by, p, visible)


@lru_cache(maxsize=64)
def _least_distance(runs: int, level: float) -> float | None:
    """Return the least distance of the distributions of two samples with a p value below a level.

    None if even samples without a common value have a larger p value.
    """
    ranks = np.arange(float(runs))
    for steps in range(1, runs + 1):
        if _p_value(ranks, ranks + steps - 0.5) < level:
            return steps / runs
    return None


def _p_value(one: FloatArray, other: FloatArray) -> float:
    from scipy.stats import ks_2samp  # noqa: PLC0415 - slow import

    with warnings.catch_warnings():
        # If SciPy's exact p value rounds to more than 1, SciPy returns the asymptotic p value.
        warnings.filterwarnings("ignore", "ks_2samp: Exact calculation unsuccessful")
        return float(ks_2samp(one, other).pvalue)


def _largest_step(one: FloatArray, other: FloatArray) -> float:
    """Return the largest distance of the distributions of two samples."""
    values = np.concatenate([one, other])
    shares = [np.searchsorted(np.sort(x), values, side="right") / len(x) for x in (one, other)]
    return float(np.max(np.abs(shares[0] - shares[1])))


def _visible(
    count: int,
    known: FloatArray,
    test: Callable[[FloatArray, FloatArray], Callable[[float], bool]],
) -> float | None:
    """Return the shift that a test finds with the probability `POWER`; None if there is none.

    `count`: number of runs of the engine.
    `known` (m, ...): sample of Ghostball's engine; the samples of the trials are drawn from it.
    `test`: for two samples, returns whether a test finds a shift of the first sample.
    """
    scale = float(np.max(np.std(known, axis=0)))
    if scale == 0.0:
        return 0.0  # any difference
    random = np.random.default_rng(0)  # the same trials for every engine
    trials = [
        test(known[random.integers(len(known), size=count)], random.choice(known, size=len(known)))
        for _ in range(_TRIALS)
    ]

    def is_visible(size: float) -> bool:
        """Return whether at most `_MISSES` trials miss the shift.

        Stop at the first miss too many.
        """
        missed = 0
        for is_found in trials:
            missed += not is_found(size)
            if missed > _MISSES:
                return False
        return True

    low, high = 0.0, 64.0 * scale
    if not is_visible(high):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_visible(middle) else (middle, high)
    return high


def _step_test(least: float) -> Callable[[FloatArray, FloatArray], Callable[[float], bool]]:
    """Return a test for a shift of numbers.

    The test finds a shift if the distance of the distributions is at least `least`.
    """
    return lambda one, other: lambda size: _largest_step(one + size, other) >= least


def _energy_test(least: float) -> Callable[[FloatArray, FloatArray], Callable[[float], bool]]:
    """Return a test for a shift of all balls along x: the energy distance exceeds `least` [m]."""

    def test(one: FloatArray, other: FloatArray) -> Callable[[float], bool]:
        # A shift doesn't change the distances within a sample.
        within = _mean_distances(one, one).mean() + _mean_distances(other, other).mean()

        def is_found(size: float) -> bool:
            between = _mean_distances(one + np.array([size, 0.0]), other).mean()
            return bool(2.0 * between - within > least)

        return is_found

    return test


def _places(one: FloatArray, known: FloatArray, level: float) -> QuantityVerdict:
    """Compare rest positions of all balls, (runs, n, 2) [m], by their energy distance."""
    together = np.concatenate([one, known])
    distances = _mean_distances(together, together)
    observed = _energy_distance(distances, len(one))
    random = np.random.default_rng(0)
    chance = np.concatenate(
        [_permuted(distances, len(one), size, random) for size in _chunks(_PERMUTATIONS)]
    )
    # Sums in another order differ by rounding.
    above = np.count_nonzero(chance >= observed - 1e-9 * abs(observed))
    p = (1 + int(above)) / (1 + _PERMUTATIONS)
    off = np.linalg.norm(one.mean(axis=0) - known.mean(axis=0), axis=1)
    visible = None
    if _least_distance(min(len(one), len(known)), level) is not None:
        least = float(np.quantile(chance, 1.0 - level))
        visible = _visible(len(one), known, _energy_test(least))
    return QuantityVerdict(
        REST_POSITIONS, math.nan, math.nan, math.nan, float(np.max(off)), p, visible
    )


def _chunks(count: int) -> list[int]:
    return [_CHUNK] * (count // _CHUNK) + [count % _CHUNK] * (count % _CHUNK > 0)


def _mean_distances(runs: FloatArray, others: FloatArray) -> FloatArray:
    """Return the distance of each ball between two runs, the mean over all balls, (k, m) [m]."""
    total = np.zeros((len(runs), len(others)))
    for ball in range(runs.shape[1]):
        total += np.hypot(*(runs[:, np.newaxis, ball] - others[:, ball]).transpose(2, 0, 1))
    mean: FloatArray = total / runs.shape[1]
    return mean


def _energy_distance(distances: FloatArray, count: int) -> float:
    """Return the energy distance of the first `count` runs and the other runs [m]."""
    first, second = distances[:count, :count], distances[count:, count:]
    return float(2.0 * distances[:count, count:].mean() - first.mean() - second.mean())


def _permuted(
    distances: FloatArray, count: int, size: int, random: np.random.Generator
) -> FloatArray:
    """Return the energy distances of random divisions of the same runs, (size,) [m]."""
    runs = len(distances)
    chosen = np.zeros((size, runs))
    order = random.permuted(np.tile(np.arange(runs), (size, 1)), axis=1)[:, :count]
    np.put_along_axis(chosen, order, 1.0, axis=1)
    reached = chosen @ distances
    within = np.sum(reached * chosen, axis=1)
    sums = np.sum(reached, axis=1)  # of the chosen runs to all runs
    between, rest = sums - within, distances.sum() - 2.0 * sums + within
    others = runs - count
    found: FloatArray = 2.0 * between / (count * others) - within / count**2 - rest / others**2
    return found
