"""Until when a shot can be predicted from its input in double precision."""

from __future__ import annotations

import numpy as np

from ghostball.engine import Scene
from ghostball.validation.diagnose.attribution._runs import ulps_away
from ghostball.validation.runs.our_run import run_ours

TOLERANCE = 1e-6
"""How far an ulp of the input may move a ball before the shot counts as unpredictable [m].

A thousandth of what the best stepping engine is off, so that chaos is told from its errors.
"""

TIMES = 2_001
"""Instants that are looked at."""


def horizon(scene: Scene, runs: int) -> float:
    """Return when our engine, given inputs an ulp away, first differs from itself by `TOLERANCE`.

    Parameters
    ----------
    scene : Scene
    runs : int
        How many such inputs are tried.

    Returns
    -------
    float [s]; infinite where it never does
    """
    base = run_ours(scene)
    first = np.inf
    for moved in ulps_away(scene, runs):
        other = run_ours(moved)
        times = np.linspace(0.0, max(base.rest_time, other.rest_time), TIMES)
        apart = np.linalg.norm(base.sample(times).positions - other.sample(times).positions, axis=2)
        late = np.flatnonzero(apart.max(axis=1) > TOLERANCE)
        if len(late):
            first = min(first, float(times[late[0]]))
    return first
