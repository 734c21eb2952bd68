"""Times at which gaps close: for the first time, and again after a contact."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from flint import arb, arb_poly

from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    SustainedContactError,
    UndecidedError,
)
from ghostball.reference_adapters.certified.drag import first_entry_of, parting
from ghostball.reference_adapters.certified.obstacle_gaps import Gap, StraightGap
from ghostball.reference_adapters.certified.roots import (
    NONE,
    ROOT,
    UNSURE,
    Bracket,
    first_entry,
    refined,
)


class Meeting(NamedTuple):
    """Time t at which a gap closes, s after the gap's time; if s is None, a lower bound [s]."""

    s: arb | None
    t: arb


def meeting(gap: Gap, bracket: Bracket, bits: int) -> Meeting | None:
    """Find the time at which an initially open gap closes, in intervals; None if never.

    `bracket`: the result of a search in doubles.
    """
    if isinstance(gap, StraightGap) and gap.ends:
        return _meeting_with_face(gap, bracket, bits)
    if gap.curved:
        if not gap.value(ZERO) > 0:
            return Meeting(None, gap.t)
        found = first_entry_of(gap.value, gap.slope, ZERO, bracket.high, bits)
        return _narrowed(gap.t, gap.value, gap.slope, found)
    if bracket.verdict == UNSURE:
        coefficients = gap.coefficients()
        if bracket.low.is_zero() and not coefficients[0] > 0:
            if coefficients[0] < 0:
                return _after_overlap(gap, coefficients, bracket.high, bits)
            return Meeting(None, gap.t)
        bracket = first_entry(coefficients, bracket.low, bracket.high, bits)
    return _narrowed(gap.t, gap.value, gap.slope, bracket)


def meeting_again(gap: Gap, high: float, bits: int, *, still: bool = False) -> Meeting | None:
    """Find the time at which a gap that is exactly 0 now closes again: now, later, or never (None).

    `still`: whether its rate is also exactly 0, although computed from intervals.

    Raises `UndecidedError` if it can't be decided whether the bodies separate;
    `SustainedContactError` if they are in resting contact.
    """
    found = _meeting_again(gap, high, bits, still=still)
    if found is not None and found.s is not None and isinstance(gap, StraightGap) and gap.ends:
        is_on_face = gap.is_on_face(found.s)
        if is_on_face is None or (not is_on_face and gap.curved):
            return Meeting(None, found.t)
        if not is_on_face:  # a parabola crosses the line at most once more
            return None
    return found


def _meeting_again(gap: Gap, high: float, bits: int, *, still: bool) -> Meeting | None:
    """As `meeting_again`, for the infinite line of a straight piece."""
    now = Meeting(ZERO, gap.t)
    if gap.curved:
        return _meeting_again_in_air(gap, arb(high), bits, still=still)
    _, *rest = gap.coefficients()
    if still:
        rest[0] = ZERO
    if all(c.is_zero() for c in rest):
        return None
    if rest[0] < 0:
        return now
    if rest[0].is_zero():
        rest = rest[1:]
        if rest[0] < 0:
            raise SustainedContactError("in resting contact", (gap.choice,), gap.t)
    if not rest[0] > 0:
        raise UndecidedError("whether they part or stay in contact", (gap.choice,), gap.t)
    opens = arb_poly(rest)
    return _narrowed(gap.t, opens, opens.derivative(), first_entry(rest, ZERO, arb(high), bits))


def _meeting_with_face(gap: StraightGap, bracket: Bracket, bits: int) -> Meeting | None:
    """Find the time at which a ball crosses the line of a face from the front, at the face."""
    at_first = gap.value(ZERO)
    in_front, low = at_first > 0, ZERO
    if not in_front:
        if not at_first < 0:
            return Meeting(None, gap.t)
        if not gap.is_behind:  # otherwise far away, in a different part of the table
            is_on_face = gap.is_on_face(ZERO)
            if is_on_face is None or (is_on_face and gap.curved):
                return Meeting(None, gap.t)
            if is_on_face:
                return _after_overlap(gap, gap.coefficients(), bracket.high, bits)
    found = bracket if in_front and bracket.verdict == ROOT else None
    while True:
        if found is None:
            found = _crossing(gap, low, bracket.high, bits, downwards=in_front)
        if found.verdict == NONE:
            return None
        if found.verdict == UNSURE:
            return Meeting(None, gap.t + found.low)
        if in_front:
            met = _narrowed(gap.t, gap.value, gap.slope, found)
            if met is None or met.s is None:
                return met
            is_on_face = gap.is_on_face(met.s)
            if is_on_face is not False:
                return met if is_on_face else Meeting(None, met.t)
        in_front, low, found = not in_front, found.high, None


def _crossing(gap: StraightGap, low: arb, high: arb, bits: int, *, downwards: bool) -> Bracket:
    """Search for the next time in [low, high] at which a ball crosses the line of a face."""
    sign = 1 if downwards else -1
    if not gap.curved:
        return first_entry([sign * c for c in gap.coefficients()], low, high, bits)
    return first_entry_of(
        lambda s: sign * gap.value(s), lambda s: sign * gap.slope(s), low, high, bits
    )


def _meeting_again_in_air(gap: Gap, high: arb, bits: int, *, still: bool) -> Meeting | None:
    opens = gap.slope
    rate = ZERO if still else opens(ZERO)
    if rate < 0:
        return Meeting(ZERO, gap.t)
    if rate.is_zero():
        opens = gap.bend
        pull = opens(ZERO)
        if pull.is_zero() and isinstance(gap, StraightGap):
            return None  # it moves along the cushion
        if pull < 0:
            raise SustainedContactError("in resting contact", (gap.choice,), gap.t)
    parted = parting(opens, high, bits) if opens(ZERO) > 0 else None
    if parted is None:
        raise UndecidedError("whether they part or stay in contact", (gap.choice,), gap.t)
    if parted >= high:
        return None
    found = first_entry_of(gap.value, gap.slope, parted, high, bits)
    return _narrowed(gap.t, gap.value, gap.slope, found)


def _after_overlap(gap: Gap, coefficients: list[arb], high: arb, bits: int) -> Meeting | None:
    """Find the next entry of balls that overlap by the rounding of the scene's numbers.

    The rule of the model (Bannerman, Strobl, Formella and Poeschel 2014): a closing overlap is an
    impact now, an opening overlap is none.
    """
    if all(c.is_zero() for c in coefficients[1:]):
        return None
    rate, pull = coefficients[1:3]
    if rate < 0:
        return Meeting(ZERO, gap.t)
    if rate.is_zero() and pull < 0:
        raise SustainedContactError("in resting contact", (gap.choice,), gap.t)
    left = first_entry([-c for c in coefficients], ZERO, high, bits)
    if left.verdict != ROOT:
        return Meeting(None, gap.t)
    again = first_entry(coefficients, left.high, high, bits)
    return _narrowed(gap.t, gap.value, gap.slope, again)


def _narrowed(
    t: arb, value: Callable[[arb], arb], slope: Callable[[arb], arb], bracket: Bracket
) -> Meeting | None:
    """Return the meeting in a bracket, as precisely as possible; times count from t."""
    if bracket.verdict == NONE:
        return None
    if bracket.verdict == ROOT:
        s = refined(value, slope, bracket.low, bracket.high)
        if s is not None:
            return Meeting(s, t + s)
    return Meeting(None, t + bracket.low)
