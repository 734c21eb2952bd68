"""Certificates contain the closed forms and the results of the oracle."""

from __future__ import annotations

import pytest
from mpmath import mpf, workdps
from oracle import solve
from proofs import SHOTS, keys, middle, proved
from shots import random_cloth_shot

from ghostball.model import COLLISION_KINDS, CUSHIONS, EventKind
from ghostball.reference_adapters.certified import (
    Certificate,
    CertifiedSettings,
    Enclosure,
    certify,
)
from ghostball.validation.scenes.library import find_scene, select
from ghostball.validation.truth.closed_forms import closed_form

NO_FORM_TO_COMPARE = {
    # Scenes without an outcome in exact numbers, or with laws without a closed form.
    "mathavan-cut",
    "cushion-stronge",  # has a closed form, but no certificate
    "corner-exact",
    "three-ball-symmetric",
    "frozen-triangle",
    "push",
    "push-line",
    "push-unequal",
    "wedged",
    # Scenes with slides or flight in air, which are rejected.
    "air-drop",
    "air-drag-sliding",
    "air-slides",
    # Thousands of impacts.
    "galperin-3",
}
MANY_SHOTS = {"throw-by-angle", "throw-by-spin"}
BY_HAND = {"cradle", "frozen-to-cushion", "stun-shot"}
"""Closed forms that treat gaps and slips of the size of rounding as 0."""


def holds(enclosure: Enclosure, value: mpf, room: mpf) -> bool:
    radius = mpf(enclosure.rad.numerator) / enclosure.rad.denominator
    return abs(middle(enclosure) - value) <= radius + room


def collisions(certificate: Certificate) -> list[tuple[str, int, int | str]]:
    return [
        (e.kind.label, e.a, CUSHIONS[e.b] if e.kind is EventKind.BALL_CUSHION else e.b)
        for e in certificate.events
        if e.kind in COLLISION_KINDS
    ]


# -- closed forms --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name in MANY_SHOTS else name
        for name in (scene.name for scene in select(["closed-form"]))
        if name not in NO_FORM_TO_COMPARE
    ],
)
def test_closed_forms_lie_within_the_enclosures(name):
    scene = find_scene(name)
    form = closed_form(scene)
    assert form is not None
    certificate = proved(scene, width=1e-45)
    with workdps(60):
        # The tolerance is 50 digits times the amplification of the shot, or the rounding of the
        # scene's numbers if the form treats such values as 0.
        room = mpf(10) ** -15 if name in BY_HAND else mpf(10) ** -38
        for position, expected in zip(certificate.positions, form.rest_positions, strict=True):
            # Without the height, which is exactly the radius and isn't part of a form.
            for enclosure, value in zip(position[:2], expected, strict=True):
                assert holds(enclosure, value, room)
                assert enclosure.width <= 1e-45
        assert holds(certificate.t_end, form.rest_time, room)
    assert tuple(collisions(certificate)) == form.event_sequence


# -- enclosures ----------------------------------------------------------------------------------


def encloses(enclosure: Enclosure, narrower: Enclosure) -> bool:
    return enclosure.lower <= narrower.lower and narrower.upper <= enclosure.upper


@pytest.mark.parametrize("name", SHOTS)
def test_a_higher_precision_lies_within_a_lower_one(name):
    scene = SHOTS[name]
    coarse, fine = (
        proved(scene, start_precision=bits, max_precision=bits, width=1.0) for bits in (212, 424)
    )
    assert keys(coarse) == keys(fine)
    for one, other in zip(coarse.events, fine.events, strict=True):
        assert encloses(one.t, other.t)
    for one, other in zip(coarse.positions, fine.positions, strict=True):
        for enclosure, narrower in zip(one, other, strict=True):
            assert encloses(enclosure, narrower)
    for one, other in zip(coarse.spins, fine.spins, strict=True):
        for enclosure, narrower in zip(one, other, strict=True):
            assert encloses(enclosure, narrower)
    assert encloses(coarse.t_end, fine.t_end)


@pytest.mark.parametrize("seed", [*range(5), 130, 219])
def test_random_shots_on_the_cloth_agree_with_the_oracle(seed):
    check_against_the_oracle(random_cloth_shot(seed))


@pytest.mark.parametrize("seed", range(4))
def test_a_restitution_that_falls_with_speed_agrees_with_the_oracle(seed):
    scene = random_cloth_shot(seed)
    law = {"cushion_restitution_loss": 0.15}
    if scene.physics.cushion == "mirror":
        law |= {"cushion": "restitution", "cushion_restitution": 0.95}
    physics = scene.physics.model_copy(update=law)
    check_against_the_oracle(scene.model_copy(update={"physics": physics}))


def check_against_the_oracle(scene):
    certificate = certify(scene, CertifiedSettings(width=1e-40))
    if certificate.ending == "sustained contact":
        pytest.skip("the oracle has no sustained contact")
    assert certificate.proved, certificate.reason
    truth = solve(scene)
    # Independent simultaneous events have no order; the oracle orders them by index.
    mine, theirs = sorted(keys(certificate)), sorted(tuple(map(int, e.key)) for e in truth.events)
    assert mine == theirs
    if not any(event.tie for event in certificate.events):
        assert keys(certificate) == [tuple(map(int, e.key)) for e in truth.events]
    with workdps(60):
        for position, exact in zip(certificate.positions, truth.positions, strict=True):
            for enclosure, value in zip(position, exact[:2], strict=True):
                assert holds(enclosure, value, mpf(10) ** -25)
        for spin, exact in zip(certificate.spins, truth.spins, strict=True):
            for enclosure, value in zip(spin, exact, strict=True):
                assert holds(enclosure, value, mpf(10) ** -22)
