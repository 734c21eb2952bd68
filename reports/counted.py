"""What runs count beyond exact events, in words: nothing is approximated in silence."""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.validation.results.store import CaseRecord, Results

COUNTED = {
    "joint_impacts": "impacts of one instant, resolved together",
    "unsolved_joint_impacts": "of those, impacts whose impulses were not found",
    "contact_steps": "steps of balls that press each other",
    "contact_pieces": "further pieces of the motion over such steps",
    "unsolved_contact_steps": "steps of pressing balls whose forces were not found",
    "pulls": "overlapping balls pulled apart",
    "put_backs": "balls put back from beyond a cushion",
    "coincident_pairs": "balls at one and the same place",
    "overlaps": "overlaps that the search for collisions left alone",
}
"""Counters of `Result.work` that stand for an approximation or a repair, in words."""

UNSOLVED = ("unsolved_joint_impacts", "unsolved_contact_steps")

COUNTED_MEANS = """\
Everything that a run did beyond exact events is counted in `Result.work`. Of `ghostball`: impacts
that share a ball at one instant have no order, and are resolved together; balls that keep pressing
each other are followed in steps, which hold every gap to a few 1e-13 m. A scene that isn't listed
needed neither. Of the others: repairs of overlaps. The time steps of engines that have one are in
the work of each scene."""

SCENES_SHOWN = 8
"""More scenes than this in a cell of a table are no longer read."""


def counted_text(case: CaseRecord) -> str:
    """Return what a run counted beyond exact events, in words; "" where there was nothing."""
    return ", ".join(f"{case.work[name]} {words}" for name, words in _present(case))


def work_text(case: CaseRecord) -> str:
    """Return every counter of a run, by its name in `Result.work`."""
    return ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in case.work.items())


def counted_rows(results: Results) -> Iterator[tuple[str, str, int, str]]:
    """Yield engine, what it counted, how often in all, and in which scenes, most first."""
    for label in results.labels:
        cases = [case for case in results.cases if case.label == label]
        for name, words in COUNTED.items():
            found = {case.scene: case.work[name] for case in cases if case.work.get(name)}
            if not found:
                continue
            most = sorted(found, key=lambda scene: (-found[scene], scene))
            shown = [f"[{scene}](#{scene}) {found[scene]}" for scene in most[:SCENES_SHOWN]]
            if len(most) > SCENES_SHOWN:
                shown.append(f"{len(most) - SCENES_SHOWN} more")
            yield label, words, sum(found.values()), ", ".join(shown)


def unsolved(results: Results) -> int:
    """Return how many joint impacts and contact steps of all runs were left without a solution."""
    return sum(case.work.get(name, 0) for case in results.cases for name in UNSOLVED)


def _present(case: CaseRecord) -> Iterator[tuple[str, str]]:
    return ((name, words) for name, words in COUNTED.items() if case.work.get(name))
