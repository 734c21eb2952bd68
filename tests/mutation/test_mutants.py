"""Copies of our packages: a bug in one is seen, is in no other, and may do what it likes there."""

from __future__ import annotations

from pathlib import Path

import pytest
from mutants import MutantError, Mutation, faults_on, planted
from mutations import MUTATIONS

from ghostball import engine

RESTITUTION = next(one for one in MUTATIONS if one.name == "restitution - 1e-6")

FEW = ["graded/head-on", "graded/draw-shot", "graded/stop"]
"""Trials that take no time."""

START = "    check_request(scene, record, max_events, max_work)\n    # The compiler"


def drastic(text: str) -> Mutation:
    """Return a bug that does something drastic in shots of one ball."""
    new = START.replace(
        "\n", f"\n    if len(scene.balls) == 1:\n        import os, time\n        {text}\n"
    )
    return Mutation("drastic", "shot.py", START, new, "", "")


def test_a_bug_is_seen_where_it_shows_and_none_in_a_plain_copy():
    with planted(RESTITUTION) as folder:
        found = faults_on(folder, FEW)
    assert found["graded/head-on"] == found["graded/stop"] == ()
    assert "quality_factor" in found["graded/draw-shot"][0]
    with planted() as folder:
        assert faults_on(folder, FEW) == dict.fromkeys(FEW, ())


@pytest.mark.parametrize(
    ("text", "limit", "reason"),
    [
        ("raise ZeroDivisionError('planted')", 60.0, "ZeroDivisionError: planted"),
        ("os._exit(7)", 60.0, "exit code 7"),
        ("time.sleep(600)", 5.0, "no answer in 5 s"),  # without its start
    ],
)
def test_a_shot_that_raises_dies_or_hangs_is_a_fault(text, limit, reason):
    with planted(drastic(text)) as folder:
        found = faults_on(folder, ["graded/head-on", "graded/stop"], time_limit=limit)
    assert found["graded/head-on"] == ()
    assert reason in found["graded/stop"][0]


def test_a_shot_without_end_is_a_fault():
    with planted(drastic("while True: pass")) as folder:
        found = faults_on(folder, ["graded/stop"], processor_limit=1.0)
    assert found == {"graded/stop": ("no end in 1 s of processor time",)}


def test_a_bug_that_breaks_a_module_is_an_error():
    broken = Mutation("broken", "errors.py", "from __future__", "from __past__", "", "")
    with (
        planted(broken) as folder,
        pytest.raises(MutantError, match=r"can't be imported.*__past__"),
    ):
        faults_on(folder, ["graded/stop"])


@pytest.mark.parametrize(
    ("file", "old", "new", "reason"),
    [
        ("motion/next_piece.py", "no such text", "x", "found 0 times"),
        ("motion/next_piece.py", "def ", "x", "exactly once"),
        ("motion/next_piece.py", "first_meeting(rx: float", "first_meeting(rx: float", "differ"),
        ("no_such.py", "x", "y", "must be one of the package"),
    ],
)
def test_a_mutation_that_does_not_fit_is_refused(file, old, new, reason):
    mutation = Mutation("odd", file, old, new, "", "")
    with pytest.raises(MutantError, match=reason), planted(mutation):
        pass


def test_the_engine_itself_stays_as_it_is():
    path = Path(engine.__file__).parent / RESTITUTION.file
    before = path.read_bytes()
    with planted(RESTITUTION) as folder:
        assert not folder.is_relative_to(path.parent.parent)
        assert RESTITUTION.new in (folder / "ghostball/engine" / RESTITUTION.file).read_text()
    assert not folder.exists()
    assert path.read_bytes() == before
