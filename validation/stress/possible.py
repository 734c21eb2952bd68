"""What no shot may do, whatever its scene: limits that several families ask for.

Beside the law, which says the same of energy and of balls that overlap each other.
"""

from __future__ import annotations

from typing import Final

from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.stress.shots import limit

POSSIBLE: Final[tuple[Criterion, ...]] = (
    limit(
        "cushion_overlap_max",
        "No ball is in a cushion, by more than rounding and what a contact may be off by.",
        claiming="rounding",
        at_most=1.0,
        of="touching",
    ),
    limit(
        "cushion_overlap_max",
        "A ball is in a cushion by no more than it moves in a time step.",
        at_most=1.0,
        of="step",
    ),
    limit("unsolved", "Every contact and every simultaneous impact has a solution.", equals=0),
)

ISOLATED: Final[tuple[Criterion, ...]] = (
    limit(
        "momentum_drift",
        "Nothing external acts on the balls: each impact rounds their momentum.",
        claiming="rounding",
        at_most=5e-13,
    ),
    limit(
        "momentum_drift",
        "Nothing external acts on the balls; 1e-6 is left to a solver's noise.",
        at_most=1e-6,
    ),
)

SKEW_OF_CONTACTS: Final = 2.0**-28
"""Asymmetry of exact motion, in diameters, where contact steps take part; without them, none.

Their forces are found by iteration over the contacts, in some order. What that leaves is less than
the tolerance of a gap; in a rack, where it may also change which of two contacts of almost one
instant comes first, it becomes visible.
"""


def symmetric(most: float) -> tuple[Criterion, ...]:
    """Return the limits on how far the mirrored shot may be from the shot [m].

    `most` [m]: for an engine that errs by rounding alone.
    """
    return (
        limit(
            "mirror_error",
            "No law knows left from right, nor a ball's place in the list; contacts that are "
            "solved by iteration may, by less than their tolerance.",
            claiming="rounding",
            at_most=most,
        ),
        limit(
            "mirror_error",
            "No law knows left from right; a solver may, by less than a ball moves in a time step.",
            at_most=1.0,
            of="step",
        ),
    )


def bounded(events: int, steps: int) -> tuple[Criterion, ...]:
    """Return the limits on the events, and the contact steps, of a shot that may not get stuck."""
    why = "Three times what any such shot needs; a ball that is stuck takes thousands."
    return (
        limit("event_count", why, at_most=events),
        limit("contact_steps", why, at_most=steps),
    )
