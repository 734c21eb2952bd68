"""The report's section on where differences come from."""

from __future__ import annotations

from pathlib import PurePosixPath

from reports import style
from reports.attribution_text import (
    TRUTHS,
    backward_text,
    compared_text,
    order_text,
    part_text,
    share_text,
)
from reports.markdown_parts import figure_link, one_line, table_of
from validation.attribution import Attribution, attributions_of
from validation.store import ResultsFolder

CAPTION = "What the differences are made of, engine by engine"

_MEANS = """\
Difference = model + step + rounding. **Step** is what goes away as an engine's step goes to zero:
its own step is halved three times or more, begun at several phases, and the limit is extrapolated
with the order that fits; its range holds every order that the phases don't exclude. **Model** is
what that limit still differs by: physics that the engine lacks or has otherwise. **Rounding** is
what an ulp of the input does. Model and step add up as vectors; the percentages are their parts
along the difference, so they add up to 100 %. Balls are compared where they end, as long as every
run has the true collisions and the shot is predictable; else at the last instant of which both
hold. **As a shot**: the change of the cue ball's speed and direction with which the true shot comes
nearest to that outcome.\
"""


def attribution_section(results: ResultsFolder, figure: PurePosixPath | None) -> list[str]:
    """Return the parts of the section; none where the folder holds no attribution of its cases."""
    found = attributions_of(results)
    if not found:
        return []
    parts = ["## Where differences come from", _MEANS, figure_link(CAPTION, figure)]
    for scene in results.scene_names:
        mine = [one for one in found if one.scene == scene]
        if mine:
            parts += [f"### {scene}: where differences come from", _table(mine), _notes(mine)]
    return parts


def _table(found: list[Attribution]) -> str:
    header = ["engine", "difference", "model", "", "step", "", "order", "rounding", "as a shot"]
    return table_of(header, (_row(one) for one in found))


def _row(one: Attribution) -> list[str]:
    if one.outcome == "not compared":
        return [f"`{one.label}`", "not compared", *[""] * 6, ""]
    difference = f"{style.format_length(one.difference)} {compared_text(one)}"
    undecided = "not converged" if one.outcome == "not converged" else part_text(one.model)
    step = "no step" if one.outcome == "no step" else part_text(one.discretisation)
    return [
        f"`{one.label}`",
        difference,
        undecided,
        share_text(one, one.model),
        step,
        share_text(one, one.discretisation),
        "–" if one.outcome == "not converged" else order_text(one),
        style.format_length(one.rounding),
        one_line(backward_text(one)),
    ]


def _notes(found: list[Attribution]) -> str:
    truth = f"- Difference from {TRUTHS[found[0].truth]}."
    return "\n".join(
        [truth]
        + [f"- `{one.label}`: {one_line(one.reason)}" for one in found if one.reason]
        + [
            f"- `{one.label}` at {style.format_time(one.instant)}: {one_line(one.until)}"
            for one in found
            if one.until
        ]
        + [
            f"- `{one.label}` approximates: {one_line('; '.join(one.approximations))}"
            for one in found
            if one.approximations and one.model is not None
        ]
    )
