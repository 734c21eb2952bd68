"""A run with one precision: its last event, its end, and ties of separate balls."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from flint import arb
from proofs import engine_keys, keys, proved
from shots import R, ball, scene_of

from ghostball.model import Table
from ghostball.reference_adapters.certified import (
    certify,
)
from ghostball.reference_adapters.certified.order import TIE_BITS
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.certified.run import CertifiedRun


def test_an_event_at_t_max_is_still_one():
    # A ball with a radius of 1/4 m at x = 1/2 m, at 1 m/s, touches x = 0 after exactly 1/4 s.
    scene = scene_of(
        ball((0.5, 0.5), (-1.0, 0.0), radius=0.25),
        table=Table(length=4.0, width=4.0),
        rolling_friction=0.0,
        t_max=0.25,
    )
    assert keys(proved(scene)) == [(1, 0, 0)] == engine_keys(scene)


def test_an_end_near_t_max_is_distinguished_from_it():
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.5, gravity=2.0, t_max=1.0)
    assert keys(proved(scene)) == [(3, 0, -1)]
    scene = scene_of(
        ball((0.0, 0.0), (0.6, 0.8)), rolling_friction=0.5, gravity=2.0, t_max=math.hypot(0.6, 0.8)
    )
    assert certify(scene).proved  # a rounding error, which the precision resolves


@pytest.mark.parametrize(("speed", "separate"), [(1.0, True), (1e28, True), (1e32, False)])
def test_a_tie_passes_only_where_no_ball_is_fast_enough_to_reach_it(speed, separate):
    """The bound on speeds must hold in all scenes; here another ball starts 1 m away."""
    scene = scene_of(ball((0.0, 0.0)), ball((1.0, 0.0), (0.0, speed)), t_max=1.0)
    one = SimpleNamespace(balls=(0,))
    assert (
        CertifiedRun(problem_of(scene), 200)._order._isolated(one, arb(0), 2.0**-TIE_BITS)
        is separate
    )


@pytest.mark.parametrize(("gap", "ending"), [(1e-13, "ambiguous"), (1e-11, "proved")])
def test_two_contacts_of_a_ball_have_an_order_only_if_their_gaps_differ_by_more_than_touching(
    gap, ending
):
    """A gap that no engine in doubles can resolve must not decide the order of events."""
    reach = 2.0 * R
    first = (0.5 * reach, 0.5 * math.sqrt(3.0) * reach)
    second = (0.5 * (reach + gap), -0.5 * math.sqrt(3.0) * (reach + gap))
    scene = scene_of(ball((-1e-12, 0.0), (1.0, 0.0)), ball(first), ball(second), t_max=0.01)
    proof = certify(scene, cached=False)
    assert proof.ending == ending
    if ending == "ambiguous":
        assert proof.reason.startswith("can't determine what comes first: ")
        assert len(proof.events) == 0
    # A single candidate needs no decision about the order.
    alone = scene_of(ball((-1e-12, 0.0), (1.0, 0.0)), ball(second), t_max=0.01)
    assert certify(alone, cached=False).proved
