"""Bad input: what judges refusals and failures sees each wrong one."""

from __future__ import annotations

import dataclasses
import math
from functools import partial
from types import SimpleNamespace

import pytest

from engine import Scene, SceneError, Status, simulate
from reference_adapters import make_engine
from validation.stress.families import bad_input
from validation.stress.families.bad_input import Generated, OddFiles
from validation.stress.malformed import malformed
from validation.stress.not_finite import (
    COLUMNS,
    UNCHECKED,
    Overflow,
    Planted,
    Unchecked,
    check_named,
    spoilt,
    unchecked_base,
)
from validation.stress.plain_scenes import Malformed
from validation.stress.refusals import (
    check_malformed,
    check_refused,
    check_syntax,
    refusal_of,
    search,
    told,
)

DATA = {
    "schema": 1,
    "name": "shot",
    "physics": {"gravity": math.nan},
    "balls": [{"id": "cue", "position": [0.0, 0.0]}],
}
TELLS = ("`physics.gravity`", "finite number", "got nan")


def raises(error: Exception):
    raise error


class TestRefusals:
    def test_a_right_one_has_no_fault(self):
        assert check_malformed(Malformed(DATA, ("physics", "gravity"), TELLS)) == ()

    @pytest.mark.parametrize(
        ("read", "fault"),
        [
            (lambda: Scene(name="a", balls=[]), None),
            (lambda: None, "is accepted"),
            (partial(raises, KeyError("gravity")), "raises KeyError"),
            (partial(raises, SceneError("")), "without a word"),
            (partial(raises, SceneError("x" * 800)), "in 800 characters"),
            (partial(raises, SceneError("a\x1b[31mb")), "break a line"),
        ],
    )
    def test_a_wrong_one_is_seen(self, read, fault):
        _, faults = refusal_of(read, "it")
        assert faults == () if fault is None else fault in faults[0]

    @pytest.mark.parametrize("missing", range(3))
    def test_a_message_that_lacks_a_part_is_seen(self, missing):
        tells = list(TELLS)
        tells[missing] = "another"
        assert "should say" in check_malformed(Malformed(DATA, ("physics",), tuple(tells)))[0]

    def test_a_message_at_another_place_is_seen(self):
        assert told("shot.toml:3: it", ("it",), "what", "shot.toml:4: ")
        assert not told("shot.toml:3: it", ("it",), "what", "shot.toml:3: ")
        faults = check_malformed(Malformed(DATA, ("balls", 0, "id"), TELLS))
        assert "should say shot.toml:8" in faults[0]

    def test_a_valid_scene_among_the_malformed_is_seen(self):
        data = DATA | {"physics": {}}
        assert "is accepted" in check_malformed(Malformed(data, (), ()))[0]
        assert "is accepted" in check_syntax(("schema = 1\nname = 'a'\n" + BALL, 1))[0]

    @pytest.mark.parametrize(
        ("status", "output", "errors"),
        [
            (0, "", "error: a.toml: no"),
            (2, "table", "error: a.toml: no"),
            (2, "", "Traceback\nerror: a.toml"),
            (2, "", "error: b.toml: no"),
        ],
    )
    def test_a_command_that_ends_otherwise_is_seen(self, tmp_path, status, output, errors):
        path = tmp_path / "a.toml"
        assert check_refused(path, 2, "", "error: a.toml: no") == []
        assert check_refused(path, status, output, errors)


BALL = "[[balls]]\nid = 'cue'\nposition = [0, 0]\n"


def test_a_search_tells_what_it_finds_and_how_many_it_tried():
    verdict = search(malformed("numbers"), lambda _: ("planted",), 20)
    assert verdict.faults == ("planted",)
    assert (verdict.broken, verdict.severity) == (1, 1.0)
    verdict = search(malformed("numbers"), lambda _: (), 20)
    assert verdict.faults == ()
    assert verdict.shots >= 20


def test_a_search_tries_the_same_again():
    seen: list[list[str]] = []
    for _ in range(2):
        cases: list[str] = []
        search(malformed("types"), lambda case, cases=cases: cases.append(str(case)) or (), 15)
        seen.append(cases)
    assert seen[0] == seen[1]


@pytest.mark.parametrize("kind", [*bad_input._KINDS, "cut", "anything"])
def test_every_kind_of_mistake_is_refused_by_name(kind):
    verdict = Generated(kind, kind, 25).run(make_engine("ghostball"))
    assert verdict.faults == ()
    assert verdict.shots >= 25


def test_odd_files_are_refused():
    verdict = OddFiles("odd-files").run(make_engine("ghostball"))
    assert verdict.faults == ()


@pytest.mark.slow
def test_the_command_line_refuses():
    verdict = bad_input.CommandLine("command-line", 1).run(make_engine("ghostball"))
    assert verdict.faults == ()


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_scene_past_the_checks_is_refused_by_name(value):
    verdict = Unchecked("unchecked", "rolling", 3, value).run(make_engine("ghostball"))
    assert verdict.faults == ()
    assert verdict.shots == len(list(spoilt(unchecked_base(UNCHECKED["rolling"], 3), value)))


def deaf(**changes):
    """Return an engine that doesn't notice: it plays the shot in order, and changes its result."""
    base = unchecked_base(UNCHECKED["rolling"], 3)
    result = dataclasses.replace(simulate(base, record="trajectory"), **changes)
    return SimpleNamespace(name="deaf", simulate=lambda scene, record: result)


def test_an_engine_that_swallows_a_nan_is_seen():
    verdict = Unchecked("unchecked", "rolling", 3, math.nan).run(deaf())
    assert verdict.broken == verdict.shots
    assert "T_MAX" in verdict.faults[0]
    # Nor is it enough to refuse without saying what.
    verdict = Unchecked("unchecked", "rolling", 3, math.nan).run(SimpleNamespace(simulate=vague))
    assert verdict.broken == verdict.shots


def vague(scene, record):
    raise SceneError("something is wrong. The scene was made without its checks")


def test_a_result_that_is_not_finite_is_seen():
    trial = Overflow("overflow", "rolling")
    verdict = trial.run(deaf(rest_time=math.inf))
    assert verdict.broken == verdict.shots
    assert trial.run(make_engine("ghostball")).faults == ()


@pytest.mark.parametrize("column", COLUMNS)
@pytest.mark.parametrize("physics", ["rolling", "sliding"])
def test_a_nan_in_the_midst_of_a_run_fails_by_name(physics, column):
    assert Planted("planted", physics, column).run(make_engine("ghostball")).faults == ()


@pytest.mark.parametrize(
    ("status", "reason", "fault"),
    [
        (Status.FAILED, '`balls[0]` ("cue") has none at t = 0.5 s', None),
        (Status.REST, '`balls[0]` ("cue") has none at t = 0.5 s', "ends in REST"),
        (Status.FAILED, '`balls[1]` ("b1") has none at t = 0.5 s', "should name ball 0"),
        (Status.FAILED, '`balls[0]` ("cue") has none at t = 0.1 s', "an instant from 0.25 s"),
        (Status.FAILED, '`balls[0]` ("cue") has none at t = nan s', "an instant from 0.25 s"),
        (Status.FAILED, "something is nan", "should name ball 0"),
    ],
)
def test_a_nan_that_is_not_named_is_seen(status, reason, fault):
    faults = check_named(status, reason, 0, 0.25)
    assert faults == [] if fault is None else fault in faults[0]
