"""The three comparisons of one scene side by side: rest positions, collision counts and energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from ghostball.model import COLLISION_KINDS
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.accuracy import cell_text
from ghostball.reports.figures._table import view_of
from ghostball.reports.page.rendering import render
from ghostball.reports.shots import Run, Shot
from ghostball.validation.results.records import ACCURACY_KINDS
from ghostball.validation.results.store import CaseRecord

WIDTH = 360.0
"""Width of the picture of rest positions, in units of its view box."""


@dataclass(frozen=True)
class Comparison:
    """The three comparisons of a scene.

    `difference`: how much the engines differ, for sorting scenes: the worst accuracy class, then
        the largest distance of a ball from its reference rest position over the width of the view.
    """

    html: Markup
    difference: tuple[int, float]


def comparison_of(shot: Shot, energy: Markup) -> Comparison | None:
    """Return the comparison of a scene; None if fewer than two engines ran, or without a reference.

    `energy`: the chart of the energy against time.
    """
    ran = [run for run in shot.runs if run.case is not None and run.case.outcome == "ran"]
    reference = _reference(shot)
    if len(ran) < 2 or reference is None:
        return None
    ends = [(run, _rests(run)) for run in ran]
    left, right, bottom, top = view_of(
        shot.scene, *(rests for _, rests in ends if rests is not None), needed=reference
    )
    scale = WIDTH / (right - left)

    def place(centre: Any) -> tuple[float, float]:
        return (centre[0] - left) * scale, (top - centre[1]) * scale

    table = shot.scene.table
    html = render(
        "comparison.html",
        scene=shot.scene,
        size=(WIDTH, (top - bottom) * scale),
        outline=[] if table is None else [place(corner) for corner in table.drawn_outline],
        holes=[]
        if table is None
        else [(*place(hole.centre), hole.radius * scale) for hole in table.holes],
        rings=[
            (*place(centre), radius * scale, ball.id)
            for centre, radius, ball in zip(
                reference, shot.scene.radii, shot.scene.balls, strict=True
            )
            if np.isfinite(centre).all()
        ],
        engines=[
            {
                "number": shot.runs.index(run),
                "name": run.style.name,
                "sign": style.SIGNS[run.style.marker],
                "said": cell_text(run.case),
                "places": []
                if rests is None
                else [place(one) for one in rests if np.isfinite(one).all()],
                "counts": _counts(run, shot.truth_counts),
            }
            for run, rests in ends
        ],
        kinds=[kind.label for kind in COLLISION_KINDS],
        most=_most(ran, shot),
        independent=shot.truth_positions is not None,
        end="At rest" if shot.end == "rest" else "At the end",
        energy=energy,
    )
    off = [_distance(rests, reference) for _, rests in ends if rests is not None]
    kinds = [
        ACCURACY_KINDS.index(run.case.accuracy.kind)
        for run in ran
        if run.case is not None and run.case.accuracy is not None and not run.case.excused
    ]
    return Comparison(html, (max(kinds, default=-1), max(off, default=0.0) / (right - left)))


def _reference(shot: Shot) -> FloatArray | None:
    """Return the reference rest positions (n, 3) [m], else the rest positions of Ghostball."""
    if shot.truth_positions is not None:
        return shot.truth_positions
    own = next((run for run in shot.runs if run.style.ours and run.case is not None), None)
    return None if own is None else _rests(own)


def _rests(run: Run) -> FloatArray | None:
    case: CaseRecord | None = run.case
    return None if case is None else case.rest_positions


def _distance(rests: FloatArray, reference: FloatArray) -> float:
    """Return the largest finite distance of a ball from its reference rest position [m]."""
    distances = np.linalg.norm((rests - reference)[:, :2], axis=1)
    return float(np.max(distances[np.isfinite(distances)], initial=0.0))


def _counts(run: Run, true: dict[str, int] | None) -> list[tuple[int, int | None]]:
    """Return, for each kind of collision, the number of collisions and the reference number.

    The reference number is None without a reference.
    """
    found = {} if run.case is None else run.case.collision_counts
    return [
        (found.get(kind.label, 0), None if true is None else true.get(kind.label, 0))
        for kind in COLLISION_KINDS
    ]


def _most(ran: list[Run], shot: Shot) -> int:
    """Return the number of collisions at which a bar has its full length, at least 1.

    This is the largest number of collisions of a kind, but at most twice the largest reference
    number: an engine with far too many collisions would make all other bars invisibly short.
    """
    counts = [count for run in ran for count, _ in _counts(run, shot.truth_counts)]
    most = max(counts, default=1)
    if shot.truth_counts and any(shot.truth_counts.values()):
        most = min(most, 2 * max(shot.truth_counts.values()))
    return max(1, most)
