"""What stands in a cell of the board: what its runs come to, as its column judges them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Annotated, Final, Literal, get_args

import numpy as np
from pydantic import BaseModel, Field

from ghostball.model import Scene
from ghostball.validation.board.column import ACCURACY, Column
from ghostball.validation.checks.verdict import is_unfinished, unfinished_text
from ghostball.validation.measured.likeness import Likeness
from ghostball.validation.results.records import (
    ACCURACY_KINDS,
    INDEPENDENT,
    Accuracy,
    AccuracyKind,
    CaseRecord,
    Motion,
    scene_from,
)

Beside = Literal["beside", "partly"]
"""Of a cell that is neither right nor wrong: of all that is asked, or of what it can play."""

Shade = Literal["good", "fair", "bad", "none", "failed"] | Beside
"""What a cell is worth that has no class of accuracy.

Up to the first threshold; up to the second; above; no value, for the engine lacks what the question
is of; not measured, for the engine crashed, hung, raised or came to no end. Or none of that.
"""

_IN_ORDER: Final = (ACCURACY_KINDS, get_args(Beside))
"""Kinds that a column is sorted by, each before the next, whatever their values."""

LIKE_A_LAW: Final = 0.01
"""How near to a law's the speeds are that are called by its name, over the first ball's."""


class Cell(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """What one engine shows of one question.

    `value`: in the column's unit: of a class, the largest error; None where there is none.
    `note`: why there is no value, or more of it.
    `scene`, `label`: the run that the cell is of; "" where the engine lacks what is asked, or no
        single run answers it.
    `earlier`: the number of the board's earlier environment that it was measured in; None: in that
        of the last run.
    """

    row: str
    column: str
    kind: AccuracyKind | Shade
    value: float | None = None
    note: str = ""
    scene: str = ""
    label: str = ""
    earlier: Annotated[int, Field(ge=0)] | None = None

    @property
    def size(self) -> float | None:
        """What a column is sorted by, the least first; None comes last."""
        for kinds in _IN_ORDER:
            if self.kind in kinds:
                worse = abs(self.value or 0.0)
                return kinds.index(self.kind) + worse / (1.0 + worse)
        return self.value


def cell_of(column: Column, row: str, cases: Sequence[CaseRecord]) -> Cell:
    """Return what the runs that a column asks of a row come to.

    `cases`: none of them where the engine lacks the settings that the column requires.
    """
    if not cases:
        steps = " or ".join(one.contact_steps or "fixed" for one in column.settings)
        return Cell(row=row, column=column.id, kind="none", note=f"it has no {steps} steps")
    if column.pick == "least":
        return _least(column, row, cases)
    if column.pick == "widest":
        return _widest(column, row, cases)
    for case in cases:
        if is_unfinished(case):
            return _cell(column, row, case, "failed", note=unfinished_text(case))
        if case.outcome != "ran":
            return _cell(column, row, case, "none", note=case.reason)
    if column.metric == ACCURACY:
        return _class(column, row, cases)
    values = [case.metrics[column.metric] for case in cases]
    for case, value in zip(cases, values, strict=True):
        if value is None:
            return _cell(column, row, case, "none", note=case.notes[column.metric])
    sizes = [float(value) for value in values if value is not None]
    if column.pick == "fastest":
        assert column.above is not None
        sizes = [
            _speed(case) if size > column.above else 0.0
            for case, size in zip(cases, sizes, strict=True)
        ]
    k = int(np.argmax(sizes))
    return _cell(column, row, cases[k], shade(column, sizes[k]), sizes[k])


def cell_of_likeness(column: Column, found: Likeness) -> Cell:
    """Return how far off real tables an engine is, and what of them it lacks."""
    here = partial(Cell, row=found.label, column=column.id)
    lacking: dict[str, list[str]] = {}
    for family in found.graded:
        if family.lacks:
            lacking.setdefault(family.lacks, []).append(family.short)
    lacks = "; ".join(f"no {', '.join(names)}: {why}" for why, names in lacking.items())
    if any(family.failed for family in found.graded):
        return here(kind="failed", note=lacks)
    if found.typical is None:
        return here(kind="none", note=lacks)
    played = [f"{one.short} {one.typical:.1f}" for one in found.graded if not one.lacks]
    note = "; ".join([", ".join(played), *([lacks] if lacks else [])])
    return here(kind="partly" if lacks else "beside", value=found.typical, note=note)


def shade(column: Column, value: float) -> Shade:
    """Return what a value is worth by its column's thresholds."""
    assert column.good is not None
    if value <= column.good:
        return "good"
    return "fair" if column.fair is None or value <= column.fair else "bad"


def law_of(column: Column, motion: Motion) -> str:
    """Return the name of the law by which balls part in a column's shot; "" where it has none."""
    speeds = motion.velocities[-1, :, 0] / motion.velocities[0, 0, 0]
    for law, wanted in column.laws.items():
        if np.abs(speeds - wanted).max() < LIKE_A_LAW:
            return law
    return f"another law: {', '.join(f'{speed:.3f}' for speed in speeds)}" if column.laws else ""


def _cell(
    column: Column,
    row: str,
    case: CaseRecord,
    kind: AccuracyKind | Shade,
    value: float | None = None,
    note: str = "",
) -> Cell:
    return Cell(
        row=row,
        column=column.id,
        kind=kind,
        value=value,
        note=note,
        scene=case.scene,
        label=case.label,
    )


def _class(column: Column, row: str, cases: Sequence[CaseRecord]) -> Cell:
    """Return the worst class, of a truth that owes nothing to any engine of the board."""
    found: list[tuple[CaseRecord, Accuracy]] = []
    for case in cases:
        if case.accuracy is None or case.truth not in INDEPENDENT:
            why = "nothing says how right it is but our engine, which stands on the board"
            return _cell(column, row, case, "none", note=why)
        found.append((case, case.accuracy))
    case, worst = max(
        found, key=lambda one: (ACCURACY_KINDS.index(one[1].kind), one[1].error or 0.0)
    )
    return _cell(column, row, case, worst.kind, worst.error, worst.sentence)


def _least(column: Column, row: str, cases: Sequence[CaseRecord]) -> Cell:
    """Return the least value of the runs that are as right as the column wants them."""
    assert column.within is not None
    most = ACCURACY_KINDS.index(column.within)
    ran = [case for case in cases if case.outcome == "ran" and not is_unfinished(case)]
    right = [
        (float(value), case)
        for case in ran
        if case.accuracy is not None
        and ACCURACY_KINDS.index(case.accuracy.kind) <= most
        and (value := case.metrics[column.metric]) is not None
    ]
    if right:
        value, case = min(right, key=lambda one: one[0])
        return _cell(column, row, case, shade(column, value), value, case.label)
    if ran:
        return _cell(column, row, ran[-1], "bad", note=f"not reached: {ran[-1].label} is the last")
    failed = next((case for case in cases if is_unfinished(case)), None)
    if failed is not None:
        return _cell(column, row, failed, "failed", note=unfinished_text(failed))
    return _cell(column, row, cases[0], "none", note=cases[0].reason)


def _widest(column: Column, row: str, cases: Sequence[CaseRecord]) -> Cell:
    """Return up to which angle the runs are right, of shots in order of their angle [degrees]."""
    assert column.within is not None
    most = ACCURACY_KINDS.index(column.within)
    reached: CaseRecord | None = None
    for case in cases:
        if is_unfinished(case):
            return _cell(column, row, case, "failed", note=unfinished_text(case))
        if case.outcome != "ran":
            return _cell(column, row, case, "none", note=case.reason)
        if case.accuracy is None or ACCURACY_KINDS.index(case.accuracy.kind) > most:
            break
        reached = case
    else:
        return _cell(column, row, cases[-1], "good", _angle(cases[-1]), "all of them")
    note = "" if case.accuracy is None else f"{case.scene}: {case.accuracy.sentence}"
    if reached is None:
        return _cell(column, row, case, "bad", note=note)
    return _cell(column, row, case, "fair", _angle(reached), note)


def _angle(case: CaseRecord) -> float:
    return angle_of(scene_from(case.definition, case.scene))


def angle_of(scene: Scene) -> float:
    """Return the angle of the first ball's way from the y axis, a side pocket's [degrees]."""
    x, y = scene.velocities[0, :2]
    return round(math.degrees(math.atan2(abs(x), abs(y))), 3)


def _speed(case: CaseRecord) -> float:
    """Return the largest speed at the start of a case's scene [m/s]."""
    velocities = scene_from(case.definition, case.scene).velocities
    return float(math.sqrt(np.max(np.sum(velocities**2, axis=1))))
