"""The end of a run of a time-stepping engine: exactly at its time, or at a limit with a reason."""

import pytest
from engine_facts import needs, play
from shots import R, ball, scene_of

from ghostball.model import Status

MU_G = 0.02 * 9.81
ROLLS = ball((0, 0), (1, 0))

PLACES = {
    "pymunk": 1e-6,
    "pymunk:contact_steps=exact": 1e-14,
    "pymunk:config=naive": 2e-3,
    "pymunk:dt=7.7e-4": 1e-6,
    "pybullet": 1e-12,
    "pybullet:contact_steps=exact": 1e-12,
    "pybullet:dt=0.3": 1e-12,
    "pybullet:config=naive": 5e-2,  # Bullet's damping
}
"""Limits on the position error at the end [m]."""


@pytest.mark.parametrize("t_max", [1.0 / 3.0, 0.7654321])
@pytest.mark.parametrize(
    ("spec", "error"),
    [pytest.param(*one, marks=needs(one[0].partition(":")[0])) for one in PLACES.items()],
)
def test_t_max_is_reached_exactly(spec, error, t_max):
    """Steps that aren't shortened would end up to dt late."""
    result = play(spec, scene_of(ROLLS, t_max=t_max))
    assert result.status is Status.T_MAX
    assert result.rest_time == t_max
    assert result.rest_positions[0, 0] == pytest.approx(t_max - 0.5 * MU_G * t_max**2, abs=error)
    if spec.startswith("pymunk"):
        speed = 1.0 - MU_G * t_max
        assert result.final_state.velocities[0, 0, 0] == pytest.approx(speed, abs=1e-12)
        assert result.final_state.angular_velocities[0, 0, 1] == pytest.approx(speed / R, rel=1e-12)


@pytest.mark.parametrize(
    ("spec", "reason"),
    [
        (
            "pymunk:max_time=0.5",
            '`max_time` = 0.5 s was reached in scene "test" before all balls came to rest: '
            'ball "b0" moves at 0.902 m/s',
        ),
        ("pymunk:max_steps=10", "`max_steps` = 10 (at t = 0.01 s) was reached"),
        pytest.param("pybullet:max_time=0.25", "`max_time` = 0.25 s", marks=needs("pybullet")),
    ],
)
def test_limits_say_what_moves_and_what_to_raise(spec, reason):
    result = play(spec, scene_of(ROLLS))
    assert result.status is Status.STEP_LIMIT
    assert reason in result.reason
    assert f"Raise {reason.partition(' ')[0]}" in result.reason
