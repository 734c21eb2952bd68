"""Closed forms in 40 digits, from the doubles of a scene, so that only an engine rounds."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from mpmath import mpf, workdps
from recorded import EPS

from ghostball.model import Scene


@pytest.fixture(autouse=True)
def forty_digits() -> Iterator[None]:
    """Compute with 40 digits in every test of a module that imports this fixture."""
    with workdps(40):
        yield


def deceleration(scene: Scene) -> mpf:
    """Return the deceleration of a rolling ball [m/s^2]."""
    return mpf(scene.physics.rolling_friction) * mpf(scene.physics.gravity)


def assert_close(value: float, exact: mpf, ulps: float) -> None:
    """Assert that a number differs from the exact one by at most `ulps` roundings."""
    error = abs(mpf(float(value)) - exact)
    assert error <= ulps * EPS * abs(exact), f"{float(error / abs(exact)) / EPS:.1f} ulp"
