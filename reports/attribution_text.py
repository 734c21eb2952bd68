"""Where a difference comes from, in words."""

from __future__ import annotations

from ghostball.reports import style
from ghostball.validation.diagnose.attribution import Attribution, BackwardError, Better, Part

AIM = 1e-3
"""The accuracy for which a step is advised [m]: what an eye sees."""


def part_text(part: Part | None) -> str:
    """Return the size of a part with its uncertainty; "–" where there is none."""
    if part is None:
        return "–"
    if not part.told_from_zero:
        most = style.format_length(part.size + part.uncertainty)
        return f"at most {most}, not told from none"
    return f"{style.format_length(part.size)} ± {style.format_length(part.uncertainty)}"


def share_text(found: Attribution) -> str:
    """Return how much of the difference is which part; "" where one part is all that is told."""
    model, step = found.model, found.discretisation
    if model is None or step is None or not (model.told_from_zero and step.told_from_zero):
        return ""
    if min(model.share, step.share) < 0.0:
        return "the two point apart, and partly hide each other"
    return f"{round(100.0 * model.share)} % model, {round(100.0 * step.share)} % step"


def ladder_text(found: Attribution) -> str:
    """Return how many runs at which steps say so; "" where there is no step."""
    if found.step is None or found.finest is None:
        return ""
    first, last = style.format_time(found.step), style.format_time(found.finest)
    return f"{found.runs} runs with steps from {first} to {last}"


def better_text(found: Attribution) -> str:
    """Return how the engine would play the shot better: as measured, and by the bound."""
    said = [
        f"`{_setting(one)}` is {style.format_length(one.difference)} off" for one in found.better
    ]
    model, step = found.model, found.finest
    if model is not None and step is not None:
        if model.told_from_zero and model.size - model.uncertainty > AIM:
            least = style.format_length(model.size - model.uncertainty)
            said.append(f"no step brings it nearer than {least}")
        elif not model.told_from_zero and model.uncertainty > AIM:
            needed = style.format_time(step * AIM / model.uncertainty)
            said.append(f"a step of {needed} would bring it within 1 mm of its end at zero step")
    return "; ".join(said)


def _setting(one: Better) -> str:
    value = one.value if isinstance(one.value, str) else f"{one.value:.3g}"
    return f"{one.setting}={value}"


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
