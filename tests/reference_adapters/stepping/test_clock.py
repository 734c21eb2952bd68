"""Equal steps that end on the end exactly."""

from __future__ import annotations

import pytest

from ghostball.reference_adapters.stepping.clock import Clock


@pytest.mark.parametrize(
    ("dt", "t_end", "count"), [(0.1, 0.3, 3), (1e-3, 1.0, 1000), (0.4, 1.0, 3), (5.0, 1.0, 1)]
)
def test_steps_are_equal_no_longer_than_asked_and_end_on_the_end(dt, t_end, count):
    clock = Clock(dt, t_end)
    assert clock.dt <= dt * (1.0 + 1e-12)
    instants = [clock.tick() for _ in range(count)]
    assert instants[-1] == clock.t == t_end
    # Multiples, not a running sum: its rounding would gather.
    assert instants[:-1] == [k * clock.dt for k in range(1, count)]
