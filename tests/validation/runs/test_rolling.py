"""A ball that is given another velocity still rolls: not one rounding of slip is left."""

import numpy as np
from hypothesis import given, strategies as st

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.runs.rolling import rolling_spin

SPEED = st.floats(-10.0, 10.0)


@given(SPEED, SPEED, st.floats(0.01, 0.1), SPEED)
def test_its_spin_is_that_of_a_ball_which_rolls_to_the_bit(x, y, radius, about_vertical):
    spin = rolling_spin((x, y, 0.0), radius, about_vertical)
    place = {"id": "cue", "position": (0.0, 0.0), "velocity": (x, y), "radius": radius}
    ball = Ball(**place, angular_velocity=spin)
    scene = Scene(name="rolls", physics=Physics(motion="sliding"), balls=[ball])
    assert spin[2] == about_vertical
    assert np.all(scene.rolls)
