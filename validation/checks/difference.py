"""What differs between two runs of the same scenes: of two engines, or of one at two times."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.records import ACCURACY_KINDS, CaseRecord

NOT_COMPARED = ("wall_time",)
"""Metrics that differ in every run: they are the machine's."""

FAILING = (Verdict.FAIL, Verdict.CRASHED)
"""Verdicts that a run must not come to."""


@dataclass(frozen=True)
class Moved:
    """A metric on both sides; None where it has no value."""

    name: str
    base: int | float | None
    head: int | float | None

    @property
    def factor(self) -> float:
        """How many times larger the head is than the base; inf where one has no value, or is 0."""
        if not self.base or not self.head:
            return math.inf
        return abs(self.head / self.base)


@dataclass(frozen=True, eq=False)
class CaseDifference:
    """One scene on both sides; None where a side has none.

    `moved`: the metrics that differ, in the order of `METRICS`.
    """

    scene: str
    base: CaseRecord | None
    head: CaseRecord | None
    moved: tuple[Moved, ...] = ()

    @property
    def verdicts(self) -> tuple[str, str]:
        """What both came to, in words."""
        base, head = (
            "not there" if case is None else verdict_of(case).words
            for case in (self.base, self.head)
        )
        return base, head

    @property
    def classes(self) -> tuple[str, str]:
        """How right both are: the kind of their accuracy, "" where nothing says it."""
        base, head = (
            "" if case is None or case.accuracy is None else case.accuracy.kind
            for case in (self.base, self.head)
        )
        return base, head

    @property
    def another_shot(self) -> bool:
        """Whether both sides have a scene of this name, and it isn't the same."""
        base, head = self.base, self.head
        return base is not None and head is not None and base.definition != head.definition

    @property
    def differs(self) -> bool:
        """Whether anything does: a verdict, a metric, the scene itself, or that it is there."""
        sides = (self.verdicts, self.classes)
        return self.another_shot or bool(self.moved) or any(a != b for a, b in sides)

    @property
    def step(self) -> int:
        """How many classes the head is better (above 0) or worse; 0 where one has none."""
        if self.another_shot or "" in self.classes:
            return 0
        base, head = (ACCURACY_KINDS.index(kind) for kind in self.classes)
        return base - head

    @property
    def got_worse(self) -> bool:
        """Whether the head is less right by a class, or fails where the base did not."""
        if self.base is None or self.head is None or self.another_shot:
            return False
        failed = verdict_of(self.head) in FAILING and verdict_of(self.base) not in FAILING
        return failed or self.step < 0

    @property
    def got_better(self) -> bool:
        """Whether the head is more right by a class, or passes where the base failed."""
        if self.base is None or self.head is None or self.another_shot or self.got_worse:
            return False
        mended = verdict_of(self.base) in FAILING and verdict_of(self.head) not in FAILING
        return mended or self.step > 0


def difference_of(
    base: Sequence[CaseRecord], head: Sequence[CaseRecord], labels: Mapping[str, str] | None = None
) -> list[CaseDifference]:
    """Compare cases of two runs, scene by scene and engine by engine.

    `labels`: which engine of the head each engine of the base is compared with, by label; the one
    of the same label where it is left out.

    Returns in the order of the base; then what only the head has.
    """
    after = {(case.scene, case.label): case for case in head}
    found = []
    for case in base:
        label = case.label if labels is None else labels.get(case.label)
        if label is not None:
            found.append(_compared(case, after.pop((case.scene, label), None)))
    wanted = None if labels is None else set(labels.values())
    rest = [case for case in after.values() if wanted is None or case.label in wanted]
    return found + [CaseDifference(case.scene, None, case) for case in rest]


def _compared(base: CaseRecord, head: CaseRecord | None) -> CaseDifference:
    if head is None or base.definition != head.definition:
        return CaseDifference(base.scene, base, head)
    moved = tuple(
        Moved(name, base.metrics.get(name), head.metrics.get(name))
        for name in METRICS
        if name not in NOT_COMPARED and base.metrics.get(name) != head.metrics.get(name)
    )
    return CaseDifference(base.scene, base, head, moved)
