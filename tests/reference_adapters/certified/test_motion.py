"""A single ball that spins in place; its motion ends with the spin."""

from __future__ import annotations

from proofs import proved
from shots import ball, scene_of

from ghostball.engine import simulate


def test_a_ball_spins_on_the_spot_where_the_cloth_does_not_rub():
    scene = scene_of(
        ball((0.0, 0.0), angular_velocity=(0.0, 10.0, 0.0)),
        ball((1.0, 0.0), angular_velocity=(0.0, 0.0, 5.0)),
        motion="sliding",
        sliding_friction=0.0,
        t_max=3.0,
    )
    certificate = proved(scene)
    assert certificate.rested
    assert certificate.events == ()
    assert float(certificate.spins[0][1]) == 10.0
    assert simulate(scene).status.complete


def test_the_end_waits_for_the_last_spin():
    certificate = proved(scene_of(ball((0.0, 0.0), angular_velocity=(0, 0, 20)), motion="sliding"))
    assert certificate.events == ()
    assert certificate.rested
    assert float(certificate.t_end) == 2.0
    assert float(certificate.spins[0][2]) == 0.0
