"""What runs count beyond exact events, in words: nothing is approximated in silence."""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.validation.results.store import CaseRecord, Results

COUNTED = {
    "joint_impacts": "impacts of one instant, resolved together",
    "unsolved_joint_impacts": "of those, impacts whose impulses were not found",
    "contact_steps": "steps of balls in resting contact",
    "contact_pieces": "further pieces of the motion over such steps",
    "unsolved_contact_steps": "steps of balls in resting contact whose forces were not found",
    "pulls": "overlapping balls pulled apart",
    "put_backs": "balls put back from beyond a cushion",
    "coincident_pairs": "balls at one and the same place",
    "overlaps": "overlaps that the search for collisions left alone",
}
"""Counters of `Result.work` that stand for an approximation or a repair, in words."""

UNSOLVED = ("unsolved_joint_impacts", "unsolved_contact_steps")

SCENES_SHOWN = 8
"""More scenes than this in a cell of a table are no longer read."""


def counted_text(case: CaseRecord) -> str:
    """Return what a run counted beyond exact events, in words; "" where there was nothing."""
    return ", ".join(f"{case.work[name]} {words}" for name, words in _present(case))


def work_text(case: CaseRecord) -> str:
    """Return every counter of a run, by its name in `Result.work`."""
    return ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in case.work.items())


def counted_rows(
    results: Results,
) -> Iterator[tuple[str, str, int, list[tuple[str, int]], int]]:
    """Yield engine, what it counted, how often in all, where most, and in how many scenes more."""
    for label in results.labels:
        cases = [case for case in results.cases if case.label == label]
        for name, words in COUNTED.items():
            found = {case.scene: case.work[name] for case in cases if case.work.get(name)}
            if not found:
                continue
            most = sorted(found, key=lambda scene: (-found[scene], scene))
            shown = [(scene, found[scene]) for scene in most[:SCENES_SHOWN]]
            yield label, words, sum(found.values()), shown, len(most) - len(shown)


def unsolved(results: Results) -> int:
    """Return how many joint impacts and contact steps of all runs were left without a solution."""
    return sum(case.work.get(name, 0) for case in results.cases for name in UNSOLVED)


def _present(case: CaseRecord) -> Iterator[tuple[str, str]]:
    return ((name, words) for name, words in COUNTED.items() if case.work.get(name))
