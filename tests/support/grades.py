"""Runs and their grades, optionally with a made-up growth of errors."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from tangent import made_up

from ghostball.engine import simulate
from ghostball.model import ExactTrajectory, Result
from ghostball.reference_adapters.certified import (
    Certificate,
    certify,
)
from ghostball.validation.grading.gradable import gradable
from ghostball.validation.grading.grading import Grade, grade as grade_by
from ghostball.validation.grading.horizon import Growth
from ghostball.validation.scenes.library import find_scene


def run_and_proof(name: str, **tangent: Any) -> tuple[Result, Certificate, Growth]:
    scene = find_scene(name)
    result = simulate(scene, record="trajectory")
    return result, certify(scene, motion=True), made_up(len(scene.balls), **tangent)


def grade(
    result: Result, certificate: Certificate, growth: Growth | None = None, **more: Any
) -> Grade:
    exact = isinstance(result.trajectory, ExactTrajectory)
    within = gradable(result.scene, certificate, exact=exact, growth=growth, **more)
    return grade_by(result, certificate, within)


def without_event(result: Result, index: int) -> Result:
    assert result.events is not None
    return replace(result, events=np.delete(result.events, index))


def clean(made: Grade) -> bool:
    return not made.missing and not made.invented and made.first is None
