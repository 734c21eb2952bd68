"""Where a difference comes from, in words and table cells: what reports and commands share."""

from __future__ import annotations

from reports import style
from validation.attribution import Attribution, BackwardError, Part

TOLD = 1.0
"""Widest range of orders that still tells one from the next."""


def part_text(part: Part | None) -> str:
    """Return the size of a part with its uncertainty; "–" where there is none."""
    if part is None:
        return "–"
    return f"{style.format_length(part.size)} ± {style.format_length(part.uncertainty)}"


def share_text(found: Attribution, part: Part | None) -> str:
    """Return a part's share of the difference; "" where it is none or its sign isn't known."""
    if part is None or found.difference is None or part.uncertainty >= found.difference:
        return ""
    return f"{round(100.0 * part.share)} %"


def order_text(found: Attribution) -> str:
    """Return the fitted order with its range, or why there is none."""
    if found.order is None or found.order_low is None or found.order_high is None:
        return "no matter what step" if found.flat else "–"
    span = f"{found.order_low:.2g} to {found.order_high:.2g}"
    if found.order_high - found.order_low <= TOLD or found.order_used is None:
        return f"{found.order:.2g} ({span})"
    return f"{found.order_used:.2g}, assumed (any of {span} fits)"


def backward_text(found: Attribution) -> str:
    """Return the backward error in a player's words; "" where there is none."""
    if found.backward is None:
        return found.no_backward
    return _stroke(found.backward, found.difference)


def _stroke(backward: BackwardError, difference: float | None) -> str:
    turn = _turn(backward.degrees)
    speed = _speed(backward.speed)
    said = " and ".join(part for part in (turn, speed) if part)
    left = style.format_length(backward.unexplained)
    of = f" of {style.format_length(difference)}" if difference else ""
    if not said:
        return f"no other speed or direction is nearer: {left} is left unexplained"
    return f"as if played {said}; {left}{of} is left unexplained"


def _turn(degrees: float) -> str:
    if degrees == 0.0:
        return ""
    return f"{abs(degrees):.2g}° to the {'left' if degrees > 0.0 else 'right'}"


def _speed(relative: float) -> str:
    if relative == 0.0:
        return ""
    return f"{100.0 * abs(relative):.2g} % {'harder' if relative > 0.0 else 'softer'}"


def compared_text(found: Attribution) -> str:
    """Return when the balls were compared."""
    return "at the end" if found.instant is None else f"at {style.format_time(found.instant)}"


TRUTHS = {
    "certified": "the certified shot",
    "closed form": "the closed form's end, with our engine's way to it",
    "our engine": "our own engine, which is not independent",
}
"""What a shot is compared with."""
