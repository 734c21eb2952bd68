"""Results of relations between shots: a table of engines, and why a relation was not judged."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from ghostball.reports.words import many
from ghostball.validation.checks.relations import RELATIONS, WORDS, bits_of, factor_of
from ghostball.validation.results.records import CaseRecord, Check


@dataclass(frozen=True)
class BrokenRelation:
    """A relation that an engine broke in a scene.

    `check`: the broken limit; of several, the first in the order of `METRICS`.
    """

    case: CaseRecord
    relation: str
    check: Check


def standing_of(case: CaseRecord, relation: str) -> str:
    """Return "kept", "broken" or "not judged" for a relation in a case; "" if it wasn't asked."""
    metrics = (factor_of(relation), bits_of(relation))
    verdicts = [check.passed for check in case.checks if check.metric in metrics]
    if not verdicts:
        return "not judged" if metrics[0] in case.metrics else ""
    return "kept" if all(verdicts) else "broken"


def asked_relations(cases: Iterable[CaseRecord]) -> list[str]:
    """Return the relations that were asked in some case."""
    named = {metric for case in cases for metric in case.metrics if metric in RELATIONS}
    return [relation for relation in WORDS if factor_of(relation) in named]


def relation_rows(cases: list[CaseRecord]) -> Iterator[list[str]]:
    """Yield a row for each engine: its label, and the number of cases by standing."""
    relations = asked_relations(cases)
    for label in dict.fromkeys(case.label for case in cases):
        mine = [case for case in cases if case.label == label]
        yield [label, *(_cell(mine, relation) for relation in relations)]


def _cell(cases: list[CaseRecord], relation: str) -> str:
    found = Counter(standing_of(case, relation) for case in cases)
    said = [f"{found[one]} {one}" for one in ("kept", "broken", "not judged") if found[one]]
    return ", ".join(said) or "–"


def broken_relations(cases: Iterable[CaseRecord]) -> Iterator[BrokenRelation]:
    """Yield the broken relations, in the order of the cases."""
    for case in cases:
        for relation in WORDS:
            metrics = (factor_of(relation), bits_of(relation))
            broken = [check for check in case.broken if check.metric in metrics]
            if broken:
                yield BrokenRelation(case, relation, broken[0])


def unjudged_relations(cases: list[CaseRecord]) -> Iterator[str]:
    """Yield why a relation was not judged, a sentence for each relation, engine and reason."""
    found: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    for relation in asked_relations(cases):
        for case in cases:
            if standing_of(case, relation) == "not judged":
                why = case.notes.get(factor_of(relation), "no limit applies")
                found[relation, case.label, why].append(case.scene)
    for (relation, label, why), scenes in found.items():
        where = scenes[0] if len(scenes) == 1 else many(len(scenes), "scene")
        yield f"{relation} was not judged on {label} in {where}: {why}"


def never_judged(cases: list[CaseRecord]) -> list[str]:
    """Return the asked relations that were judged in no case at all."""
    return [
        relation
        for relation in asked_relations(cases)
        if not any(standing_of(case, relation) in ("kept", "broken") for case in cases)
    ]


RELATION_KEY = (
    "Each engine also simulated related shots, such as the mirrored shot. kept: both runs agree "
    "within the engine's own error, or bit for bit if the engine promises identical bits."
)
"""Explanation of the table of `relation_rows`."""
