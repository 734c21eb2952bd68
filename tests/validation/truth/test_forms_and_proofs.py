"""Closed forms and proofs share no formula: where they end apart, one is wrong."""

from __future__ import annotations

from fractions import Fraction

import pytest
from mpmath import mpf

from ghostball.engine import CUSHIONS
from ghostball.engine.result import COLLISION_KINDS
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import closed_form

ROUNDING = Fraction(1, 10**17)
"""Distance [m], [s] of a closed form from its proof: forms have 50 digits, proofs 18 and more."""


def fraction(value: mpf) -> Fraction:
    """Return the rational number that a multiprecision one is."""
    sign, mantissa, exponent, _ = value._mpf_
    size = int(mantissa) << exponent if exponent >= 0 else Fraction(int(mantissa), 1 << -exponent)
    return Fraction(-size if sign else size)


@pytest.mark.parametrize(
    "name",
    [
        "head-on",
        "unequal-balls",
        "restitution-cut",
        "corner-double-bounce",
        "sliding-swerve",
        "draw-shot",
        "masse",
        "han-running",
        "english-check",
        "throw-slip",
        "throw-alciatore",
        "flight-bounces",
        "flight-throw",
    ],
)
def test_a_closed_form_ends_where_it_is_proved_to_end(name: str) -> None:
    """Of each law and way of moving, scenes that are proved in no time."""
    scene = find_scene(name)
    form, proof = closed_form(scene), certify(scene, CertifiedSettings(max_events=5_000))
    assert form is not None
    assert proof.proved
    ends = [*(x for place in form.rest_positions for x in place), form.rest_time]
    proved = [*(x for place in proof.positions for x in place[:2]), proof.t_end]
    for x, enclosure in zip(ends, proved, strict=True):
        assert abs(fraction(x) - enclosure.mid) - enclosure.rad <= ROUNDING
    log = [event for event in proof.events if event.kind in COLLISION_KINDS]
    stated = [
        (kind, a, CUSHIONS.index(b) if isinstance(b, str) else b)
        for kind, a, b in form.event_sequence
    ]
    assert sorted((event.kind.label, event.a, event.b) for event in log) == sorted(stated)
