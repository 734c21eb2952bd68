"""A comparison as JUnit: what fails the gate fails there, and what can't fail doesn't pass."""

from xml.etree import ElementTree

import pytest
from regressions import identical, quantity, regression, uncompared, worse

from ghostball.validation.baselines.junit import moved_text, regression_xml


def parsed(compared):
    root = ElementTree.fromstring(regression_xml(compared))
    cases = {(case.get("classname"), case.get("name")): case for case in root.iter("testcase")}
    return root, cases


def verdict(case) -> str:
    kinds = [child.tag for child in case if child.tag in ("failure", "error", "skipped")]
    assert len(kinds) <= 1
    return kinds[0] if kinds else "passed"


def test_a_scene_that_is_the_same_passes():
    root, cases = parsed(regression(identical(), outcome="passed"))
    assert {name for _, name in cases} == {
        "verdict", "energy_rise", "events", "hash", "first difference",
    }  # fmt: skip
    assert {verdict(case) for case in cases.values()} == {"passed"}
    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("5", "0", "0")


def test_a_scene_that_fails_says_by_how_much_and_how_to_see_it():
    _, cases = parsed(regression(worse()))
    of = {name: case for (_, name), case in cases.items()}
    assert verdict(of["verdict"]) == "failure"
    assert of["verdict"][0].get("message") == "worse: rest error 3 mm, was 7 fm"
    assert of["verdict"][0].text == "ghostball run break-7"
    message = of["rest_error_max"][0].get("message")
    assert message == "rest_error_max must be at most 1e-12, got 0.003 (before: 7e-15)"
    assert "as accepted" in of["rest_error_max"][0].text
    assert verdict(of["hash"]) == "failure"
    assert "which is missing now" in of["first difference"][0].get("message")


def test_what_only_warns_passes_and_says_so():
    _, cases = parsed(regression(worse()))
    roots = cases["break-7", "roots"]
    assert verdict(roots) == "passed"
    output = roots.find("system-out").text
    assert "warning: roots must be within [10, 10], got 12 (before: 10)" in output


def test_a_run_time_that_fails_the_gate_fails_here_too():
    # Both revisions ran by turns, so that the time is no chance; the bits are the same.
    slower = identical(failed=True, time=worse().time, summary="2.0 times as slow")
    _, cases = parsed(regression(slower, against="main"))
    failed = {name for (_, name), case in cases.items() if verdict(case) == "failure"}
    assert failed == {"verdict", "run time"}
    assert "slower: 2.0 times as long" in cases["stop", "run time"][0].get("message")


def test_a_scene_without_a_baseline_may_fail_its_limits():
    _, cases = parsed(regression(uncompared(failed=True)))
    assert verdict(cases["head-on", "verdict"]) == "failure"


def test_what_is_not_judged_does_not_pass():
    _, cases = parsed(regression(worse()))
    assert verdict(cases["break-7", "bounds"]) == "skipped"


def test_nothing_to_compare_with_is_an_error():
    root, cases = parsed(regression(uncompared(), outcome="no-baseline"))
    assert verdict(cases["head-on", "verdict"]) == "error"
    assert root.get("errors") == "1"
    root, cases = parsed(regression(outcome="no-baseline", warnings=("another machine",)))
    assert verdict(cases["regression", "baselines"]) == "error"
    assert root.find("system-out").text == "another machine"


@pytest.mark.parametrize("change", ["rounding-only", "better", "results-changed"])
def test_bits_that_may_move_pass_and_say_so(change):
    _, cases = parsed(regression(worse(change=change, failed=False, time=None), outcome="passed"))
    assert "failure" not in {verdict(case) for case in cases.values()}
    for name in ("hash", "first difference", "verdict"):
        assert verdict(cases["break-7", name]) == "passed"
        assert change in cases["break-7", name].find("system-out").text


def test_a_counter_alone_may_fail_a_scene():
    # The bits are the same: only the scene's verdict and the counter fail.
    counter = quantity("roots", within=False, base=10, head=12, low=10, high=10)
    scene = identical(failed=True, counters=(counter,), summary="more roots")
    _, cases = parsed(regression(scene))
    failed = {name for (_, name), case in cases.items() if verdict(case) == "failure"}
    assert failed == {"verdict", "roots"}


def test_a_hash_that_is_missing_is_an_error():
    _, cases = parsed(regression(identical(head_hash="")))
    assert verdict(cases["stop", "hash"]) == "error"


def test_past_the_horizon_a_difference_is_told_not_judged():
    first = worse().first_difference.model_copy(update={"before_horizon": False})
    _, cases = parsed(regression(worse(first_difference=first)))
    case = cases["break-7", "first difference"]
    assert verdict(case) == "passed"
    assert case.find("system-out").text.startswith("past the predictability horizon")


def test_baselines_of_no_scene_are_told():
    root, _ = parsed(regression(identical(), stale=("gone",), outcome="passed"))
    assert root.find("system-out").text == "baseline of a scene that is no more: gone"


def test_what_moved_is_told_to_the_last_digit():
    moved = quantity(base=1.0, head=1.0000000000000002, low=0.5, high=1.0)
    assert moved_text(moved) == (
        "energy_rise must be within [0.5, 1.0], got 1.0000000000000002 (before: 1.0)"
    )
    assert "at least 0.5, got nothing" in moved_text(quantity(head=None, low=0.5))
    assert "must be 0.0, as it was" in moved_text(quantity())
