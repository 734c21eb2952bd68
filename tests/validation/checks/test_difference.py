"""What differs between two runs of the same cases, and whether it got worse."""

from __future__ import annotations

from dataclasses import replace

from stored_cases import record

from ghostball.validation.checks.difference import difference_of
from ghostball.validation.results.records import Accuracy, Check

HELD = Check("rest_error_max", 1e-16, "at_most", 1e-12, "m", passed=True, reason="by hand")
CASES = [
    record(
        "ghostball", scene, status="rest", accuracy=Accuracy("exact", error=1e-16), checks=(HELD,)
    )
    for scene in ("stop", "head-on")
]


def test_what_fails_in_the_second_alone_got_worse_and_the_other_way_did_not():
    crashed = [replace(CASES[0], outcome="failed", reason="planted", checks=()), CASES[1]]
    assert [one.got_worse for one in difference_of(CASES, crashed)] == [True, False]
    assert not any(one.got_worse for one in difference_of(crashed, CASES))
    assert [one.got_better for one in difference_of(crashed, CASES)] == [True, False]


def test_a_class_is_what_counts_first():
    worse = replace(CASES[0], accuracy=Accuracy("millimetres", error=2e-3))
    (found,) = difference_of(CASES[:1], [worse])
    assert (found.got_worse, found.step, found.classes) == (True, -3, ("exact", "millimetres"))
    assert difference_of([worse], CASES[:1])[0].got_better


def test_another_shot_of_the_same_name_is_not_compared():
    other = replace(CASES[0], definition={**CASES[0].definition, "t_max": 1.0})
    (found,) = difference_of(CASES[:1], [other])
    assert found.another_shot
    assert found.differs
    assert found.moved == ()
    assert not found.got_worse
