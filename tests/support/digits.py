"""Closed forms in forty digits of a scene's own doubles: what is off is an engine's rounding."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from mpmath import mpf, workdps
from recorded import EPS

from ghostball.model import Scene


@pytest.fixture(autouse=True)
def forty_digits() -> Iterator[None]:
    """Compute with forty digits in every test of the module that imports this."""
    with workdps(40):
        yield


def deceleration(scene: Scene) -> mpf:
    """Return by how much the cloth slows a ball that rolls [m/s^2]."""
    return mpf(scene.physics.rolling_friction) * mpf(scene.physics.gravity)


def assert_close(value: float, exact: mpf, ulps: float) -> None:
    """Assert that a number is the exact one, but for so many roundings."""
    error = abs(mpf(float(value)) - exact)
    assert error <= ulps * EPS * abs(exact), f"{float(error / abs(exact)) / EPS:.1f} ulp"
