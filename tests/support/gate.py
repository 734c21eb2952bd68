"""What the tests of the gate compare: runs of small shots, and logs made up event by event."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ghostball.engine import simulate
from ghostball.model import EVENT_DTYPE, Ball, EventKind, Events, Scene, Table
from ghostball.model.hashes import bits_hash, sequence_hash
from ghostball.validation.baselines.bands import Bands, band_of_counter, band_of_metric
from ghostball.validation.baselines.baseline import Accepted
from ghostball.validation.baselines.classify import classify
from ghostball.validation.baselines.observed import KEPT_EVENTS, Observed, judged
from ghostball.validation.baselines.regression import Regression, SceneChange
from ghostball.validation.baselines.rounding import Allowance, allowance_of

ACCEPTED = Accepted(
    date="2026-01-02", revision="0123456789ab", platform="a machine", reason="It is right."
)
METRICS = {"rest_error_max": 1e-12, "rest_error_ulps": 3.0, "matching_events": 2}
"""Some that a shot might have had."""


def cut_shot(speed: float = 1.0, name: str = "cut") -> Scene:
    """A ball that cuts another, and both meet cushions."""
    return Scene(
        name=name,
        title=f"Two balls, {name}",
        balls=[
            Ball(id="cue", position=(0.5, 0.6), velocity=(speed, 0.0)),
            Ball(id="object", position=(1.0, 0.628)),
        ],
        table=Table(length=2.54, width=1.27),
    )


def roll_shot(speed: float = 1.0, name: str = "roll") -> Scene:
    """One ball that rolls to rest."""
    cue = Ball(id="cue", position=(0.5, 0.25), velocity=(speed, 0.5))
    return Scene(name=name, title=f"One ball, {name}", balls=[cue])


def observed(scene: Scene, *, like: Scene | None = None, **changes: Any) -> Observed:
    """Return what our engine does in a scene; as if it were in that scene `like`."""
    run = Observed.of_result(simulate(scene, record="events"))
    run = replace(run, metrics=judged(METRICS, "certified"), truth="certified")
    if like is not None:
        run = replace(run, scene_hash=observed(like).scene_hash)
    return replace(run, **changes)


def bands_of(base: Observed) -> Bands:
    """Return the bands that accepting a run would give it."""
    return Bands(
        {name: band_of_metric(name, base.metrics) for name in base.metrics},
        {name: band_of_counter(count) for name, count in base.work.items()},
    )


def compared(base: Observed, head: Observed, scene: Scene) -> SceneChange:
    """Compare two runs with the bands of the first, and what rounding explains in a scene."""
    return classify(base, head, bands_of(base), lambda: allowance_of(scene))


def log(*rows: tuple[float, EventKind, int, int]) -> Events:
    """Return an event log of rows: instant, kind, a, b."""
    return np.array([(t, int(kind), a, b) for t, kind, a, b in rows], dtype=EVENT_DTYPE)


def long_log(count: int) -> Events:
    """Return so many collisions, one a second, of balls 0 and 1, 1 and 2 alternately."""
    return log(*((k + 1.0, EventKind.BALL_BALL, k % 2, k % 2 + 1) for k in range(count)))


def with_events(base: Observed, events: Events, *, kept: int | None = None) -> Observed:
    """Return a run with other events and their hashes; of a baseline where only some are kept."""
    return replace(
        base,
        events=events[:kept],
        event_count=len(events),
        bits=bits_hash(events, base.rest_positions),
        sequence=sequence_hash(events),
    )


def at_rest(base: Observed, positions: Sequence[Sequence[float]]) -> Observed:
    """Return a run that ends at other places [m]."""
    places = np.array(positions, dtype=np.float64)
    return replace(base, rest_positions=places, bits=bits_hash(base.events, places))


def as_accepted(run: Observed) -> Observed:
    """Return a run as a baseline holds it: the first events only."""
    return replace(run, events=run.events[:KEPT_EVENTS])


def allowance(
    count: int,
    *,
    horizon: float = math.inf,
    time: float = 1e-12,
    rest: float | None = 1e-12,
    balls: int = 2,
) -> Allowance:
    """Return an allowance of `time` [s] for each of `count` events, and `rest` [m] at the end."""
    return Allowance(
        horizon,
        math.inf,
        np.full(count, time),
        None if rest is None else np.full(balls, rest),
    )


def changes(regression: Regression) -> dict[str, str]:
    """Return what became of each scene of a comparison."""
    return {one.scene: one.change for one in regression.scenes}
