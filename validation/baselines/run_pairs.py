"""Compare two runs, or two engines of one run, case by case, for `diff` and `--against`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ghostball.validation.baselines.compare import compare
from ghostball.validation.baselines.compared_run import ComparedRun
from ghostball.validation.baselines.regression import SceneChange
from ghostball.validation.baselines.rounding import allowance
from ghostball.validation.checks.verdict import FAILING, unfinished_text, verdict_of
from ghostball.validation.results.records import ACCURACY_KINDS, CaseRecord
from ghostball.validation.results.store import Results

Pair = tuple[CaseRecord | None, CaseRecord | None]
"""A scene's case in the base and in the head; None if a run doesn't have the case."""


def paired(base: Results, head: Results, labels: Mapping[str, str]) -> list[Pair]:
    """Return the pairs of cases of two runs: in the order of the base, then cases of the head only.

    `labels`: the engine of the head for each engine of the base, by label; {} compares each engine
        with itself.
    """
    chosen = [case for case in base.cases if not labels or case.label in labels]
    after = {
        (case.scene, case.label): case
        for case in head.cases
        if not labels or case.label in labels.values()
    }
    pairs: list[Pair] = [
        (case, after.pop((case.scene, labels.get(case.label, case.label)), None)) for case in chosen
    ]
    return pairs + [(None, case) for case in after.values()]


def changes_of(base: Results, head: Results, pairs: Sequence[Pair]) -> list[SceneChange]:
    """Compare the cases of two runs.

    A change fails if the head has a worse accuracy class, or if only the head's case fails.
    """
    found = []
    for one, two in pairs:
        if one is None or two is None:
            case, where = (two, base) if one is None else (one, head)
            assert case is not None
            why = f"missing: {where.path} doesn't contain this case"
            change = SceneChange(
                scene=case.scene, title=case.title, change="not-comparable", summary=why
            )
            found.append(change.model_copy(update={"label": case.label}))
        else:
            found.append(_change(base, one, head, two))
    return found


def _change(base: Results, one: CaseRecord, head: Results, two: CaseRecord) -> SceneChange:
    before, after = ComparedRun.stored(base, one), ComparedRun.stored(head, two)
    if one.label == two.label:
        found = compare(before, after, lambda: allowance(after))
    else:
        found = compare(before, after)
    label = " -> ".join(dict.fromkeys([one.label, two.label]))
    if found.change == "not-comparable":
        return found.model_copy(update={"label": label})
    fails = verdict_of(two) in FAILING and verdict_of(one) not in FAILING
    broken = [check.sentence for check in two.broken] if fails else []
    broken += [why] if fails and (why := unfinished_text(two)) else []
    kinds = [case.accuracy.kind for case in (one, two) if case.accuracy is not None]
    drops = len(kinds) == 2 and ACCURACY_KINDS.index(kinds[0]) < ACCURACY_KINDS.index(kinds[1])
    return found.model_copy(
        update={"label": label, "failed": fails or drops, "broken": tuple(broken)}
    )
