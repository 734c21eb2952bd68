"""Tests of random stacks: which balls fall off, which stay, and equal results on all paths.

They fail if a ball is held out of balance, or isn't held in balance, if energy increases, if balls
overlap, or if bounces don't end.
"""

from __future__ import annotations

import numpy as np
import pytest
from in_space import faults_in_space
from same import CHECKS
from stacks import KINDS, STAYS, stack_of

from ghostball.engine import simulate
from ghostball.model import Phase, Status

NUMBERS = range(16)
"""Numbers of the stacks of each kind."""

LIES_HIGH = "height of a ball at rest over the cloth"


@pytest.mark.compiled
@pytest.mark.parametrize("kind", KINDS)
def test_balls_fall_off_or_stay(kind):
    """No ball sinks into another ball, and the energy doesn't increase."""
    found = {}
    for number in NUMBERS:
        result = simulate(stack_of(kind, number), record="trajectory", max_events=200_000)
        faults = [fault for fault in faults_in_space(result) if LIES_HIGH not in fault]
        if result.status is not Status.REST:
            faults.append(f"it ends as {result.status.name}")
        here = result.phases(np.array([result.rest_time]))[0] != Phase.GONE
        high = here & (result.rest_positions[:, 2] > 1.001 * result.scene.radii)
        if list(np.flatnonzero(high)) != ([len(here) - 1] if kind in STAYS else []):
            faults.append(f"{high} lie on other balls")
        if faults:
            found[number] = faults
    assert found == {}


@pytest.mark.compiled
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("check", ["sampled", "cells", "renumbered", "mirrored"])
def test_stacks_are_the_same_in_mirrors_renumbered_and_with_cells(kind, check):
    """Renumbered stacks must start without ties, which the order of the balls resolves."""
    scenes = {number: stack_of(kind, number) for number in NUMBERS}
    if check == "renumbered":
        scenes = {number: scene for number, scene in scenes.items() if _begins_in_turn(scene)}
    chosen = list(scenes)[:6]
    found = {number: CHECKS[check](scenes[number]) for number in chosen}
    assert {number: differ for number, differ in found.items() if differ} == {}


def _begins_in_turn(scene):
    """Return whether all distances of the uppermost ball from the balls below are different."""
    *below, above = (np.array(ball.position) for ball in scene.balls)
    distances = np.sort([np.linalg.norm(above - place) for place in below])
    return bool(np.all(np.diff(distances) > 1e-12))
