"""Words for an engine's error: the cause, its start, its size and its remedy.

>>> reason_of(explain(find_scene("stop"), make_engine("mine:simulate")))
'From the start, mine:simulate behaves as if `rolling_friction` were 0.0143: 5/7 of 0.02. ...'
"""

from __future__ import annotations

from ghostball.model import EventKind
from ghostball.reports import style
from ghostball.validation.diagnose.attribution import Attribution
from ghostball.validation.diagnose.contact_states import ContactFault
from ghostball.validation.diagnose.explanation import Explanation
from ghostball.validation.diagnose.motion_differences import differs_before_end
from ghostball.validation.diagnose.wrong_factor import Factor

SHOWN = 3
"""Digits of a coefficient that is found by a search; time steps change the fourth digit."""


def reason_of(explanation: Explanation) -> str:
    """Return the cause of the error in words; "" if the explanation looked for no cause."""
    found, label = explanation.attribution, explanation.label
    if explanation.contradiction:
        return f"The result of {label} can't be compared yet: {explanation.contradiction}."
    if found is None:
        return ""
    if explanation.factor is not None:
        return _factor_text(explanation, explanation.factor)
    if explanation.fault is not None:
        return f"{fault_text(explanation, explanation.fault)} {_sentence(_off(explanation))}"
    off = _off(explanation)
    if found.outcome == "agrees" and found.instant is not None:
        when = style.format_time(found.instant)
        return (
            f"{label} agrees with the reference up to t = {when}. The rest of the shot can't be "
            f"compared: {found.until}. So a later difference is not an error: {off}."
        )
    if found.outcome in ("rounding", "agrees"):
        step = found.ladder[0].step if found.ladder else 0.0
        if differs := differs_before_end(explanation.result, explanation.known, step):
            return f"The final positions of {label} are right ({off}), but {differs}."
        return f"{label} is right: {off}, explained by rounding."
    if found.late is not None and found.outcome == "step":
        return _late_by_step(explanation, found)
    if found.outcome == "step":
        if found.instant is not None:
            return _until_then(explanation, found)
        return f"{label} is right except for its time step: {off}. {_shorter(explanation)}"
    if found.outcome == "unseparated":
        return _unseparated(explanation, found)
    since = _since(explanation)
    if found.outcome == "model":
        what = "uses different physics" + (" at every time step" if found.ladder else "")
        cure = (
            "Its declared approximations are listed below"
            if found.approximations
            else "No single coefficient of the scene explains this: compare the engine's model "
            "with docs/physics.md"
        )
        return f"{since}, {label} {what}: {off}. {cure}."
    return f"{since}, {label} has wrong collisions: {off}. No single coefficient explains this."


def fault_text(explanation: Explanation, fault: ContactFault) -> str:
    """Return the fault at contacts in words."""
    label, physics = explanation.label, explanation.scene.physics
    contact = "ball collision" if fault.kind is EventKind.BALL_BALL else "cushion contact"
    which = f"each {contact} (median of {fault.count})"
    if fault.count == 1:
        which = f"its {contact}"
    if fault.what == "slide":
        slows = physics.gravity * physics.rolling_friction
        return (
            f"The balls of {label} slide after a {contact}, but {label} claims that they roll "
            f"without slip. After {which} a ball's velocity changes by {fault.measured:.3g} m/s²; "
            f"a rolling ball slows by {slows:.3g} m/s². Let balls roll from the contact on, or "
            "claim `Feature.SLIDING` in place of `Feature.ROLLING`."
        )
    if fault.what == "energy":
        return (
            f"In {label}, energy {_change(fault.measured)} at {which}; by the scene's impact law "
            f"it {_change(fault.right)}. No single coefficient explains the whole motion."
        )
    return (
        f"Just after {which}, velocities of {label} differ from the scene's impact law by "
        f"{_percent(fault.measured)} of the largest speed before, though the energy is right. No "
        "single coefficient explains the whole motion."
    )


def _change(ratio: float) -> str:
    share = _percent(ratio - 1.0)
    if share == "0 %":
        return "stays the same"
    return f"{'rises' if ratio > 1.0 else 'falls'} by {share}"


def _percent(share: float) -> str:
    percent = 100.0 * abs(share)
    return "0 %" if percent < 0.05 else f"{percent:.2g} %"


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}."


def _late_by_step(explanation: Explanation, found: Attribution) -> str:
    """Return the words for collisions that differ because of the time step."""
    finest, label = found.ladder[-1], explanation.label
    text = (
        f"The time step of {label} is the cause. {_lateness(found)} The first wrong collision is "
        f"at t = {_first_wrong(found)}, and {_off(explanation)}."
    )
    if finest.wrong_from is None:
        text += f" With a time step of {style.format_time(finest.step)} every collision is right."
    if found.with_exact_steps is not None:
        exact = style.format_length(found.with_exact_steps)
        text += (
            f" With time steps that end at contacts (`contact_steps=exact`) the error is {exact}."
        )
    return text


def _unseparated(explanation: Explanation, found: Attribution) -> str:
    """Return the words for a cause that can't be assigned to the time step or the model."""
    shares = _lateness(found) if found.shared else "No collision before that is shared by all runs."
    return (
        f"The time step and the model of {explanation.label} can't be separated: the first wrong "
        "collision is "
        f"at t = {_first_wrong(found)}. {shares} {_sentence(_off(explanation))}"
    )


def _first_wrong(found: Attribution) -> str:
    first = found.ladder[0].wrong_from
    assert found.instant is not None
    return style.format_time(found.instant if first is None else first)


def _lateness(found: Attribution) -> str:
    """Return the time errors of the shared collisions, with the longest and the shortest step."""
    first, *_, last = found.ladder
    assert first.late is not None
    assert last.late is not None
    what = "The time of the first collision is"
    if found.shared != 1:
        what = f"The times of the first {found.shared} collisions are"
    return (
        f"{what} up to {style.format_time(first.late)} off with a time step of "
        f"{style.format_time(first.step)}, and up to {style.format_time(last.late)} off with "
        f"{style.format_time(last.step)}."
    )


def _until_then(explanation: Explanation, found: Attribution) -> str:
    """Return the cause of the error in the first part of a shot, if only this can be compared."""
    assert found.instant is not None
    assert found.difference is not None
    when, then = style.format_time(found.instant), style.format_length(found.difference)
    return (
        f"Up to t = {when}, the error of {explanation.label} is {then}, caused by its time step. "
        f"{_shorter(explanation)} The rest of the shot can't be compared: {found.until}. At the "
        f"end, {_off(explanation)}."
    )


def _factor_text(explanation: Explanation, factor: Factor) -> str:
    is_spin = factor.what.endswith("spin")
    right = "the scene's" if is_spin else f"{factor.right:g}"
    value = factor.relation if is_spin else f"{factor.value:.{SHOWN}g}: {factor.relation}"
    where = "The error"
    if factor.until < explanation.result.rest_time:
        where += f" up to t = {style.format_time(factor.until)}"
    found = explanation.attribution
    if found is not None and found.ladder:
        where += f", with a time step of {style.format_time(found.ladder[-1].step)},"
    share = factor.after / factor.before
    left = _percent(share) if share >= 5e-4 else "less than 0.05 %"
    return (
        f"{_since(explanation)}, {explanation.label} behaves as if {factor.name} were {value} "
        f"{right}. {where} is {style.format_length(factor.before)}. With {right} it would be "
        f"{style.format_length(factor.after)}, {left} of the error."
        + _physical(explanation, factor)
        + "".join(f" Equally well explained if {one}." for one in factor.rivals)
    )


def _physical(explanation: Explanation, factor: Factor) -> str:
    """Return a coefficient's meaning in speeds and accelerations; "" if it needs none."""
    gravity = explanation.scene.physics.gravity
    if factor.what in ("rolling_friction", "sliding_friction"):
        how = factor.what.removesuffix("_friction")
        right, value = (f"{gravity * one:.{SHOWN}g}" for one in (factor.right, factor.value))
        return f" A {how} ball should slow by {right} m/s\u00b2, but slows by {value}."
    if factor.what == "ball_restitution":
        return (
            " Restitution is the separation speed of two balls divided by their approach speed, "
            "along the line through their centres."
        )
    if factor.what == "cushion_restitution":
        return (
            " Restitution is the rebound speed of a ball divided by its approach speed, both "
            "perpendicular to the cushion."
        )
    return ""


def _since(explanation: Explanation) -> str:
    onset = explanation.onset
    if onset is None or onset[1] is None:
        return "From the start"
    event = onset[1]
    when = style.format_time(event.t)
    return f"From t = {when}, when {event.describe(explanation.scene)}"


def _off(explanation: Explanation) -> str:
    if not explanation.result.status.complete:
        return "the run does not finish"
    distances = explanation.rest_distances
    ball = int(distances.argmax())
    name, off = explanation.scene.balls[ball].id, style.format_length(float(distances[ball]))
    return f'"{name}" stops {off} from its reference position'


def _shorter(explanation: Explanation) -> str:
    found = explanation.attribution
    assert found is not None
    shortest = found.ladder[-1]
    left = style.format_length(shortest.difference)
    text = f"With a time step of {style.format_time(shortest.step)} the error is {left}"
    if found.with_exact_steps is not None:
        exact = style.format_length(found.with_exact_steps)
        text += f"; with time steps that end at contacts (`contact_steps=exact`), {exact}"
    return f"{text}."
