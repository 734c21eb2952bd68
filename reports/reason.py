"""What is wrong with an engine's shot, in a sentence: what, since when, how much, what cures it.

>>> reason_of(explain(find_scene("stop"), make_engine("mine:simulate")))
'From the start, mine:simulate plays as if `rolling_friction` were 0.01429: 5/7 of 0.02. ...'
"""

from __future__ import annotations

from ghostball.reports import style
from ghostball.validation.diagnose.attribution import Attribution
from ghostball.validation.diagnose.explanation import Explanation
from ghostball.validation.diagnose.wrong_factor import Factor

SHOWN = 4
"""Digits of a coefficient that is found by a search."""


def reason_of(explanation: Explanation) -> str:
    """Return the sentence; "" where nothing was asked for that could say it."""
    found = explanation.attribution
    if found is None:
        return ""
    if explanation.factor is not None:
        return _factor_text(explanation, explanation.factor)
    label, off = explanation.label, _off(explanation)
    if found.instant is not None and found.outcome in ("rounding", "step"):
        return _until_then(explanation, found)
    if found.outcome == "rounding":
        return f"{label} is right: {off}, no more than roundings make."
    if found.outcome == "step":
        return f"{label} is right but for its step: {off}. {_shorter(explanation)}"
    since = _since(explanation)
    if found.outcome == "model":
        what = "plays other physics, whatever its step"
        cure = (
            "It says what it approximates, below"
            if found.approximations
            else "No single coefficient of the scene explains it: compare what happens there with "
            "docs/physics.md"
        )
        return f"{since}, {label} {what}: {off}. {cure}."
    return f"{since}, {label} plays another shot: {off}. No single coefficient explains it."


def _until_then(explanation: Explanation, found: Attribution) -> str:
    """Return what is known of a shot that could be compared for a part of it alone."""
    assert found.instant is not None
    assert found.difference is not None
    when, then = style.format_time(found.instant), style.format_length(found.difference)
    cause = "no more than roundings make"
    if found.outcome == "step":
        cause = f"which is its step's. {_shorter(explanation).removesuffix('.')}"
    return (
        f"Up to t = {when}, {explanation.label} is {then} off, {cause}. What comes later can't be "
        f"judged ({found.until}): {_off(explanation)}."
    )


def _factor_text(explanation: Explanation, factor: Factor) -> str:
    is_spin = factor.what.endswith("spin")
    right = "the scene's" if is_spin else f"{factor.right:.{SHOWN}g}"
    value = factor.relation if is_spin else f"{factor.value:.{SHOWN}g}: {factor.relation}"
    by = ""
    if factor.until < explanation.result.rest_time:
        by = f" by t = {style.format_time(factor.until)}"
    return (
        f"{_since(explanation)}, {explanation.label} plays as if {factor.name} were {value} "
        f"{right}. That makes it {style.format_length(factor.before)} off{by}; with {right} "
        f"instead, {style.format_length(factor.after)} would be left."
        + _physical(explanation, factor)
        + "".join(f" As well as if {one}." for one in factor.rivals)
    )


def _physical(explanation: Explanation, factor: Factor) -> str:
    """Return what that is in quantities that a program computes; "" where it is one itself."""
    gravity = explanation.scene.physics.gravity
    if factor.what in ("rolling_friction", "sliding_friction"):
        how = factor.what.removesuffix("_friction")
        right, value = (f"{gravity * one:.{SHOWN}g}" for one in (factor.right, factor.value))
        return f" A {how} ball should slow by {right} m/s\u00b2, and slows by {value}."
    if factor.what == "ball_restitution":
        return " It is the share of their closing speed with which balls part along their centres."
    if factor.what == "cushion_restitution":
        return " It is the share of its speed towards a cushion with which a ball leaves it."
    return ""


def _since(explanation: Explanation) -> str:
    onset = explanation.onset
    if onset is None or onset[1] is None:
        return "From the start"
    event = onset[1]
    when = style.format_time(event.t)
    return f"From {event.describe(explanation.scene, 'hitting')} on (t = {when})"


def _off(explanation: Explanation) -> str:
    if not explanation.result.status.complete:
        return "it comes to no end"
    distances = explanation.rest_distances
    ball = int(distances.argmax())
    name, off = explanation.scene.balls[ball].id, style.format_length(float(distances[ball]))
    return f'"{name}" ends {off} off'


def _shorter(explanation: Explanation) -> str:
    found = explanation.attribution
    assert found is not None
    shortest = found.ladder[-1]
    left = style.format_length(shortest.difference)
    text = f"A step of {style.format_time(shortest.step)} leaves {left}"
    if found.with_exact_steps is not None:
        exact = style.format_length(found.with_exact_steps)
        text += f"; steps that end at contacts, `contact_steps=exact`, leave {exact}"
    return f"{text}."
