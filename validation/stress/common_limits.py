"""Limits that hold for every shot; several families use them.

They come in addition to the limits for every engine, on energy and on overlaps of balls.
"""

from __future__ import annotations

from typing import Final

from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.stress.shots import limit

POSSIBLE: Final[tuple[Criterion, ...]] = (
    limit(
        "cushion_overlap_max",
        "A ball overlaps a cushion by no more than rounding and the tolerance of a contact.",
        claiming="rounding",
        at_most=1.0,
        of="touching",
    ),
    limit(
        "cushion_overlap_max",
        "A ball overlaps a cushion by no more than it moves in a time step.",
        at_most=1.0,
        of="step",
    ),
    limit("unsolved", "Every contact and every simultaneous impact has a solution.", equals=0),
)

ISOLATED: Final[tuple[Criterion, ...]] = (
    limit(
        "momentum_drift",
        "No external force acts on the balls; only rounding changes their momentum.",
        claiming="rounding",
        at_most=5e-13,
    ),
    limit(
        "momentum_drift",
        "No external force acts on the balls; 1e-6 allows for the noise of a solver.",
        at_most=1e-6,
    ),
)

SKEW_OF_CONTACTS: Final = 2.0**-28
"""Asymmetry of exact motion with contact steps, in diameters; without contact steps it is zero.

Contact forces are found by iteration over the contacts, in some order. The remaining error is below
the tolerance of a gap. It becomes visible in a rack, where it may also change the order of two
almost simultaneous contacts.
"""


def symmetric(most: float) -> tuple[Criterion, ...]:
    """Return the limits on the distance between the mirrored shot and the shot [m].

    `most` [m]: the limit for an engine whose only error is rounding.
    """
    return (
        limit(
            "mirror_error",
            "The laws are symmetric in left and right and in the order of balls; an iterative "
            "solution of contacts may break the symmetry by less than its tolerance.",
            claiming="rounding",
            at_most=most,
        ),
        limit(
            "mirror_error",
            "The laws are symmetric; the solver of an engine may break the symmetry by less than a "
            "ball moves in a time step.",
            at_most=1.0,
            of="step",
        ),
    )


def bounded(events: int, steps: int) -> tuple[Criterion, ...]:
    """Return the limits on the events and the contact steps of a shot that must not get stuck."""
    why = "Three times the largest number in a shot of this kind; a stuck ball needs thousands."
    return (
        limit("event_count", why, at_most=events),
        limit("contact_steps", why, at_most=steps),
    )
