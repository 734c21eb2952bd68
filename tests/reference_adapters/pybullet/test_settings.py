"""What pybullet's settings stand for where nothing is said."""

from __future__ import annotations

from typing import Any

import pytest

from ghostball.reference_adapters.pybullet.settings import PybulletSettings


@pytest.mark.parametrize(
    ("settings", "step", "kernels"),
    [
        ({}, 1e-3, ()),
        ({"config": "naive"}, 1.0 / 240.0, ()),
        ({"contact_steps": "exact"}, 0.02, ("contact times",)),
        ({"config": "naive", "dt": 0.01}, 0.01, ()),
    ],
)
def test_steps_and_kernels_by_configuration(
    settings: dict[str, Any], step: float, kernels: tuple[str, ...]
) -> None:
    """Fails where pybullet's own step is another, or fixed steps wait for a compiler."""
    chosen = PybulletSettings(**settings)
    assert (chosen.step, chosen.kernels, chosen.iterations) == (step, kernels, 50)
