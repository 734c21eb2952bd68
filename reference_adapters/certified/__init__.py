"""Certified truth: what happens in a shot, proved event by event in ball arithmetic.

    >>> from ghostball.reference_adapters.certified import certify
    >>> certificate = certify(scene)
    >>> certificate.ending, certificate.events_proved, certificate.t_end.width

It shares the model with our engine and nothing else: other code, from the cited equations, on
numbers that are balls sure to hold the true ones (Johansson 2017, Arb). Every number of the scene
is the very double that was given. Each candidate for the next event has its time isolated
(`roots`); the earliest is an event once it surely comes before all others (`run`); where that
can't be decided, the precision is doubled and everything starts again (`prove`), up to a cap.

What can't be decided at the cap is "ambiguous": exact ties and tangencies, with their names;
nothing is reported beyond. Ties of events of different balls that can't feel each other pass, in
either order the outcome is the same. Sustained contact is certified up to where it begins, and so
is a slide in air, which has no closed form: `validation.truth.integration` runs such a shot by the
same events and impacts, with integrated slides (`integrated_slide`). Flight is a parabola
(`flight`), and what meets in the air does so in space (`gaps`, `obstacle_gaps`); the rules by which
the model leaves out the lowest bounces are part of what is proved. Where a ball comes to lie on
another, or on a nose, the proof ends.

What differs from our engine, which rounds: a gap of 1e-17 m between balls of a rack is a gap here,
and a slip of 1e-17 m/s is a slip; and a slow impact on a resting ball is an impact, however low.
"""

from ghostball.reference_adapters.certified.api import certify
from ghostball.reference_adapters.certified.certificate import (
    Certificate,
    Choice,
    Enclosure,
)
from ghostball.reference_adapters.certified.engine import CertifiedEngine
from ghostball.reference_adapters.certified.settings import CertifiedSettings

__all__ = [
    "Certificate",
    "CertifiedEngine",
    "CertifiedSettings",
    "Choice",
    "Enclosure",
    "certify",
]
