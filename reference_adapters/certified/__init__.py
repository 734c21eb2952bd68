"""Certified results: the events of a shot, proved one by one in ball arithmetic.

    >>> from ghostball.reference_adapters.certified import certify
    >>> certificate = certify(scene)
    >>> certificate.ending, certificate.events_proved, certificate.t_end.width

The package shares only the model with Ghostball's engine: it is separate code, written from the
cited equations, and its numbers are intervals ("balls") that are guaranteed to contain the exact
values (Johansson 2017, Arb). Every number of the scene is taken as the exact value of its double.
The time of each candidate for the next event is isolated (`roots`). The earliest candidate is the
next event if it is proved to come before all others (`run`). If the order can't be decided, the
precision is doubled and the computation starts again (`prove`), up to a maximum.

Anything that can't be decided at the maximum precision is "ambiguous": exact ties and tangencies.
The certificate names the events, and ends there. Ties of events of different balls that can't
affect each other are accepted, because the outcome is the same in either order. A shot with resting
contact is certified up to the start of the contact. A shot with a slide in air, which has no closed
form, is certified up to the slide: `validation.truth.integration` computes such shots with this
package, but integrates the slides (`integrated_slide`). Flight is a parabola (`flight`), and
contacts of airborne balls are contacts in space (`gaps`, `obstacle_gaps`); the rules by which the
model merges the lowest bounces are part of the proof. The proof ends if a ball comes to lie on a
different ball or on a nose.

Differences from Ghostball's engine, which rounds: a gap of 1e-17 m between balls of a rack is a gap
here, a slip of 1e-17 m/s is a slip, and every slow impact on a resting ball is an impact.
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
