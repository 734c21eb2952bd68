"""Run times with confidence intervals, and what a machine's noise makes of them."""

from __future__ import annotations

import math
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Annotated, Any, Final, Literal

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine import GhostballError, Scene
from validation.baselines.regression import TimeChange, Timing
from validation.bench.measurements import machine_name
from validation.bench.running import run
from validation.bench.timing import Progress, Task, take_turns
from validation.results.files import told, write_whole

SCHEMA: Final = 1

ROUNDS = 15
"""Samples of a scene: each by turns with all others, so that a slow moment hits all."""

RUNS = 5
"""Runs whose median is one sample: a run takes some ten microseconds."""

_MACHINES = "machines"


class TimesError(GhostballError, ValueError):
    """A file of a machine's times that can't be read or written."""


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)


Seconds = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class SceneTimes(_Model):
    """Run time of one scene on one machine [s], and from which ratio on it counts as slower.

    `low` and `high` are the least and the greatest of the processes' medians, `median` theirs.
    `noise` is the largest ratio of the medians of two processes that ran the same code by turns.
    """

    median: Seconds
    low: Seconds
    high: Seconds
    samples: int = Field(ge=1)
    noise: float = Field(ge=1.0, allow_inf_nan=False)
    threshold: float = Field(gt=1.0, allow_inf_nan=False)


class MachineTimes(_Model):
    """What `ghostball calibrate` measured on one machine."""

    schema_version: Literal[1] = Field(default=SCHEMA, alias="schema")
    machine: str
    environment: dict[str, Any]
    processes: int = Field(ge=2)
    scenes: dict[str, SceneTimes]


def median_interval(values: Sequence[float], confidence: float = 0.95) -> tuple[float, float]:
    """Return the interval that holds the median of what `values` are samples of, so surely.

    By order statistics (Conover 1999, section 3.2), whatever the distribution; (-inf, inf) where
    there are too few samples to be as sure.
    """
    ordered, n = sorted(values), len(values)
    tail, rank = 0.0, 0
    while rank < (n + 1) // 2:
        tail += math.comb(n, rank) / 2.0**n
        if 2.0 * tail > 1.0 - confidence:
            break
        rank += 1
    if rank == 0:
        return -math.inf, math.inf
    return ordered[rank - 1], ordered[n - rank]


def timing_of(samples: Sequence[float]) -> Timing:
    """Return what samples of a run time came to; the interval of a few is their range."""
    low, high = median_interval(samples)
    return Timing(
        median=median(samples),
        low=max(low, min(samples)),
        high=min(high, max(samples)),
        samples=len(samples),
    )


def time_scenes(
    scenes: Sequence[Scene], *, rounds: int = ROUNDS, progress: Progress | None = None
) -> dict[str, Timing]:
    """Time our engine in this process, all scenes by turns, after a warm-up.

    Raises
    ------
    KeyboardInterrupt
        Half a measurement is none.
    """

    def task(scene: Scene) -> Task:
        def prepare() -> Callable[[Callable[[], float]], Mapping[str, float]]:
            run(scene)
            return lambda _: {"seconds": median(run(scene).wall_time for _ in range(RUNS))}

        return Task(scene.name, prepare)

    found = take_turns(
        [task(scene) for scene in scenes], rounds, clock=time.perf_counter, progress=progress
    )
    if found.interrupted:
        raise KeyboardInterrupt
    return {name: timing_of(values["seconds"]) for name, values in found.values.items()}


def compare_times(head: Timing, known: SceneTimes | None) -> TimeChange:
    """Compare a run time with that of another day; another day is no proof, so it only warns."""
    if known is None:
        return TimeChange(base=None, head=head, words=_UNCALIBRATED)
    base = Timing(median=known.median, low=known.low, high=known.high, samples=known.samples)
    ratio_low = head.low / base.high
    slower = ratio_low > known.threshold
    ratio = head.median / base.median
    return TimeChange(
        base=base,
        head=head,
        ratio=ratio,
        ratio_low=ratio_low,
        ratio_high=head.high / base.low,
        threshold=known.threshold,
        slower=slower,
        words=f"took {ratio:.2f} times as long as when this machine was calibrated (it counts as "
        f"slower from {known.threshold:.2f} on)"
        if slower
        else "",
    )


def compare_samples(
    base: Sequence[float], head: Sequence[float], threshold: float | None
) -> TimeChange:
    """Compare run times that two revisions took by turns: samples of one round are a pair.

    Nothing counts as slower without a threshold: what the machine's noise is, nobody measured.
    """
    ratios = [b / a for a, b in zip(base, head, strict=True)]
    low, high = median_interval(ratios, 0.999)
    ratio = median(ratios)
    slower = threshold is not None and low > threshold
    words = "" if threshold is not None else _UNCALIBRATED
    if slower:
        words = f"{ratio:.2f} times as slow, {low:.2f} at least"
    return TimeChange(
        base=timing_of(base),
        head=timing_of(head),
        ratio=ratio,
        ratio_low=max(low, min(ratios)),
        ratio_high=min(high, max(ratios)),
        threshold=threshold,
        slower=slower,
        words=words,
    )


def times_path(baselines: Path, environment: Mapping[str, Any]) -> Path:
    """Return the file that a machine's times are kept in."""
    return baselines / _MACHINES / f"{machine_name(dict(environment))}.toml"


def load_times(path: Path) -> MachineTimes | None:
    """Read the times of a machine; None where it was never calibrated.

    Raises
    ------
    TimesError
    """
    try:
        return MachineTimes.model_validate(tomllib.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise TimesError(f"{path}: can't be read: {error}. {_AGAIN}") from None
    except ValidationError as error:
        raise TimesError(f"{path}: {told(error)}. {_AGAIN}") from None


def save_times(times: MachineTimes, path: Path) -> None:
    """Write the times of a machine, whole or not at all.

    Raises
    ------
    TimesError
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, tomli_w.dumps(times.model_dump(by_alias=True, exclude_none=True)))
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise TimesError(
            f"{path}: can't be written: {reason}. Choose another `--baselines`"
        ) from error


_UNCALIBRATED = "this machine was not calibrated for it: `ghostball calibrate`"
_AGAIN = "Remove it and run `ghostball calibrate`"
