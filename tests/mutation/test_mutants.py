"""Copies of our packages: a bug in one is seen, is in no other, and may do what it likes there."""

from __future__ import annotations

import pytest
from mutants import MutantError, Mutation, faults_on, planted

FEW = ["shipped/head-on", "shipped/draw-shot", "shipped/stop"]
"""Shots that take no time."""

START = "    check_request(scene, record, max_events, max_work)\n    off ="


def drastic(text: str) -> Mutation:
    """Return a bug that does something drastic in shots of one ball."""
    new = START.replace(
        "\n", f"\n    if len(scene.balls) == 1:\n        import os, time\n        {text}\n"
    )
    return Mutation("drastic", "engine/shot.py", START, new, "", "")


@pytest.mark.parametrize(
    ("text", "limit", "reason"),
    [
        ("raise ZeroDivisionError('planted')", 60.0, "ZeroDivisionError: planted"),
        ("os._exit(7)", 60.0, "exit code 7"),
        ("time.sleep(600)", 5.0, "no answer in 5 s"),  # without its start
    ],
)
def test_a_shot_that_raises_crashes_or_hangs_is_a_fault(text, limit, reason):
    with planted(drastic(text)) as folder:
        found = faults_on(folder, ["shipped/head-on", "shipped/stop"], time_limit=limit)
    assert found["shipped/head-on"] == ()
    assert reason in found["shipped/stop"][0]


def test_a_bug_that_breaks_a_module_is_an_error():
    broken = Mutation("broken", "engine/tangents.py", "from __future__", "from __past__", "", "")
    with (
        planted(broken) as folder,
        pytest.raises(MutantError, match=r"can't be imported.*__past__"),
    ):
        faults_on(folder, ["shipped/stop"])


@pytest.mark.parametrize(
    ("file", "old", "new", "reason"),
    [
        ("engine/motion/next_piece.py", "no such text", "x", "found 0 times"),
        ("engine/motion/next_piece.py", "def ", "x", "exactly once"),
        (
            "engine/motion/next_piece.py",
            "first_meeting(rx: float",
            "first_meeting(rx: float",
            "differ",
        ),
        ("engine/no_such.py", "x", "y", "must be one of our packages"),
    ],
)
def test_a_mutation_that_does_not_fit_is_refused(file, old, new, reason):
    mutation = Mutation("odd", file, old, new, "", "")
    with pytest.raises(MutantError, match=reason), planted(mutation):
        pass
