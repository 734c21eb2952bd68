"""Criteria files: refused files, precedence and coverage of criteria, and judging a value."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from ghostball.validation.checks.criteria import Criteria, criteria_beside
from ghostball.validation.checks.criterion import CLAIMS, CriteriaError, Criterion, Selector

FIXED = {"contact_steps": "fixed", "dt": 0.001, "gate": True}
EXACT = {"contact_steps": "exact", "dt": 0.001, "gate": True}


def criterion(*engines: str, metric: str = "rest_error_max", **limit: float) -> Criterion:
    return Criterion.model_validate(
        {"engines": engines, "metric": metric, "reason": "because", **(limit or {"at_most": 1.0})}
    )


def criteria(*items: Criterion) -> Criteria:
    return Criteria(criteria=items)


# --- the engines that a criterion covers


@pytest.mark.parametrize(
    ("selector", "covered"),
    [
        ("pymunk", True),
        ("pymunk:dt=1e-3", True),  # equal numbers in different spellings
        ("pymunk:dt=0.002", False),
        ("pymunk:dt=small", False),
        ("pymunk:gate=TRUE", True),
        ("pymunk:gate=1", False),
        ("pymunk:gate=true,contact_steps=fixed", True),
        ("pymunk:gate=true,contact_steps=exact", False),
        ("pybullet", False),
        ("*", True),
        ("*:contact_steps=fixed", True),
        ("*:contact_steps=exact", False),
        ("*:unknown=1", False),  # not a setting of this engine
    ],
)
def test_a_selector_compares_the_effective_settings(selector: str, covered: bool) -> None:
    assert Selector.parse(selector).covers("pymunk", FIXED) is covered


def test_a_selector_with_a_setting_that_the_engine_lacks_is_refused() -> None:
    # The selector would never match, so the criterion would check nothing.
    with pytest.raises(
        CriteriaError, match=r"`pymunk:contact_step=exact` names the setting `contact_step`"
    ):
        Selector.parse("pymunk:contact_step=exact").covers("pymunk", FIXED)


@pytest.mark.parametrize("table", ["criteria", "steps", "beyond_step"])
def test_an_engine_that_nobody_installed_is_refused(table: str) -> None:
    more = {
        "criteria": {"metric": "rest_error_max", "at_most": 1.0},
        "steps": {"late": ["ball-ball"], "energy_noise": 1e-9},
        "beyond_step": {},
    }
    row = {"engines": ["pimunk"], "reason": "because"} | more[table]
    read = Criteria.model_validate({table: [row]})
    with pytest.raises(CriteriaError, match=rf"x.toml: `{table}\[0\].*\"pimunk\".*mean `pymunk`"):
        read.check_engines(["ghostball", "pymunk"], "x.toml")


# --- precedence of criteria


@pytest.mark.parametrize(
    "special",
    [
        criterion("pymunk:contact_steps=exact", at_most=2.0),
        # Otherwise "at most 1 m" would still apply, although "at least 2 m" is meant to replace it.
        criterion("pymunk:contact_steps=exact", at_least=2.0),
    ],
)
def test_the_selector_with_most_settings_wins_whatever_the_order(special: Criterion) -> None:
    every, general = criterion("*"), criterion("pymunk", at_most=1.0)
    for both in (criteria(every, general, special), criteria(special, general, every)):
        assert both.applying_to("pymunk", EXACT) == (special,)
        assert both.applying_to("pymunk", FIXED) == (general,)
        assert both.applying_to("mine", {}) == (every,)


def test_precedence_is_per_metric_and_a_range_is_two_criteria() -> None:
    time = criterion("pymunk", metric="rest_time_error")
    low, high = (
        criterion("pymunk:contact_steps=exact", **limit)
        for limit in ({"at_least": 1.0}, {"at_most": 2.0})
    )
    assert set(criteria(time, low, high).applying_to("pymunk", EXACT)) == {time, low, high}


def test_equally_specific_criteria_that_both_cover_an_engine_are_refused() -> None:
    both = criteria(
        criterion("pymunk:contact_steps=exact"), criterion("pymunk:dt=1e-3", at_most=2.0)
    )
    assert len(both.applying_to("pymunk", FIXED)) == 1
    with pytest.raises(CriteriaError, match=r"`rest_error_max` apply equally .*a setting"):
        both.applying_to("pymunk", EXACT)


def test_what_an_engine_claims_decides_which_row_holds() -> None:
    any_one = criterion("*", at_most=3.0)
    exact, rounding = (
        criterion("*", at_most=at_most).model_copy(update={"claiming": claim})
        for claim, at_most in (("exact", 2.0), ("rounding", 1.0))
    )
    rows = criteria(any_one, exact, rounding)
    found = {claim: rows.applying_to("mine", {}, claim) for claim in CLAIMS}
    assert found == {"less": (any_one,), "exact": (exact,), "rounding": (rounding,)}
    assert criteria(exact).applying_to("mine", {}, "rounding") == (exact,)
    assert criteria(exact).applying_to("mine", {}, "less") == ()


# --- judging a value


@pytest.mark.parametrize(
    ("limit", "value", "passed"),
    [
        ({"at_most": 2.0}, 2.0, True),
        ({"at_most": 2.0}, math.nextafter(2.0, 3.0), False),
        ({"at_least": 2.0}, 2.0, True),
        ({"at_least": 2.0}, math.nextafter(2.0, 1.0), False),
        ({"equals": 3}, 3, True),
        ({"equals": 3}, 4, False),
        ({"at_most": 2.0}, math.nan, False),
        ({"at_least": 2.0}, math.nan, False),
        ({"at_most": 0.0}, 0.0, True),  # 0 is a limit, not a missing one
    ],
)
def test_a_limit_includes_its_bound(limit: dict[str, float], value: float, passed: bool) -> None:
    check = criterion("pymunk", **limit).check(value)
    assert check.passed is passed
    assert (check.limit_kind, check.limit) == next(iter(limit.items()))
    assert (check.unit, check.reason) == ("m", "because")


def test_no_value_fails_and_our_engine_against_itself_gets_no_verdict() -> None:
    check = criterion("pymunk").check(None, "the run stopped early")
    assert (check.passed, check.note) == (False, "the run stopped early")
    own = criterion("ghostball").check(0.0, reference=True)
    assert own.passed is None
    assert "itself" in own.note


# --- files


GOOD = """
truth = "engine"
[[criteria]]
engines = ["pymunk", "pybullet:contact_steps=exact"]
metric = "collision_count"
equals = 3
reason = "counted by hand"
"""

RULE = """\
[[steps]]
engines = ["pymunk"]
late = ["ball-ball"]
energy_noise = 1e-9
reason = "by hand"
"""

AGAIN = GOOD.replace('truth = "engine"', "")


def test_a_file_is_read_back(tmp_path: Path) -> None:
    assert criteria_beside(tmp_path / "shot.toml") == Criteria(), "there is none yet"
    path = tmp_path / "shot.expect.toml"
    path.write_text(GOOD)
    read = criteria_beside(tmp_path / "shot.toml")
    assert read == Criteria.load(path)
    assert read.truth == "engine"
    (only,) = read.criteria
    assert [str(selector) for selector in only.engines] == [
        "pymunk",
        "pybullet:contact_steps=exact",
    ]
    assert (only.limit_kind, only.limit, only.metric) == ("equals", 3, "collision_count")
    path.write_text(GOOD + AGAIN.replace("equals = 3", "at_least = 3"))
    assert len(Criteria.load(path).criteria) == 2


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (GOOD, '"collision_count"', '"collision_cuont"', r"\[0\].metric` .*`collision_count`\?"),
        (GOOD, "equals = 3", "", r":3: `criteria\[0\]` must give exactly one .* got none of them"),
        (GOOD, "equals = 3", "equals = 3\nat_most = 4", r"one .* got `at_most` and `equals`"),
        (GOOD, "equals = 3", "equals = nan", r"`criteria\[0\].equals` .*got nan"),
        (GOOD, "equals = 3", 'equals = "3"', r"`criteria\[0\].equals` .*got '3'"),
        (GOOD, "equals = 3", "equals = true", r"`criteria\[0\].equals` .*got True"),
        (GOOD, '"counted by hand"', '"  "', r"`criteria\[0\].reason` must not be blank"),
        (GOOD, 'reason = "counted by hand"', "", r"`criteria\[0\].reason` is missing"),
        (GOOD, "reason =", "raeson =", r"`criteria\[0\].raeson` is not a known field"),
        (GOOD, 'truth = "engine"', 'truth = "guess"', r"`truth` must be .*got 'guess'"),
        (GOOD, 'truth = "engine"', "thruth = 1", r"`thruth` is not a known field.* `truth`\?"),
        (GOOD, '["pymunk", "pybullet:contact_steps=exact"]', "[]", r"\[0\].engines` .*at least 1"),
        (GOOD, '"pymunk",', '"pymunk:fast",', r"engines\[0\]`: a setting must be `key=value`"),
        (GOOD, '"pymunk",', "7,", r"`criteria\[0\].engines\[0\]` must be an engine's name"),
        (GOOD, "equals = 3", "equals 3", r"not valid TOML: .*line 6"),
        (GOOD, '"collision_count"', '"collisions"', r":5: .*\.metric` must be a known metric"),
        (
            GOOD,
            'metric = "collision_count"\nequals = 3',
            'metric = "accuracy"\nat_most = "nanometers"',
            r":3: `criteria\[0\]` must be a class of `accuracy`, got 'nanometers'. From",
        ),
        (GOOD, "equals = 3", 'equals = 3\nclaiming = "most"', r"\[0\].claiming` must be"),
        (RULE, '"ball-ball"', '"bal-ball"', r"`steps\[0\].late\[0\]` must be .*got 'bal-ball'"),
        (RULE, "1e-9", "-1e-9", r"`steps\[0\].energy_noise` must be greater than 0, got -1e-09"),
        (RULE, "late", "lte", r"`steps\[0\].lte` is not a known field.* `late`\?"),
        (RULE, "reason", "cause", r"`steps\[0\].cause` .*Known here: engines, reason, late"),
        (RULE, 'reason = "by hand"', "", r"`steps\[0\].reason` is missing"),
        (RULE, 'late = ["ball-ball"]', "", r"`steps\[0\].late` is missing"),
        (
            # With "*", any engine with a setting of this name would have no limits.
            '[[excused]]\nengines = ["pymunk", "*:config=naive"]\nreason = "so"\n',
            "",
            "",
            r":1: `excused\[0\]` must name .*got '\*:config=naive'",
        ),
        (GOOD + AGAIN, "equals = 3", "equals = 4", r"\[1\]` repeats `equals` .* for `pymunk`"),
        (
            GOOD + AGAIN.replace("equals = 3", "at_least = 4"),
            "",
            "",
            r":10: .* must be in order, .*got equals 3, at_least 4",
        ),
    ],
)
def test_a_wrong_file_is_refused_by_name_and_field(
    tmp_path: Path, text: str, old: str, new: str, message: str
) -> None:
    assert old in text
    path = tmp_path / "shot.expect.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(CriteriaError, match=message) as caught:
        Criteria.load(path)
    assert str(path) in str(caught.value)


def test_an_engine_that_runs_nowhere_is_refused_with_the_line(tmp_path: Path) -> None:
    path = tmp_path / "shot.expect.toml"
    path.write_text(GOOD.replace('"pymunk"', '"pimunk"'))
    read = Criteria.load(path)
    with pytest.raises(CriteriaError, match="must name installed engines") as caught:
        read.check_engines(["ghostball", "pymunk", "pybullet"], "x.toml")
    assert str(caught.value).startswith(f"{path}:3: `criteria[0].engines`")
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CriteriaError, match="can't read the limits"):
        Criteria.load(tmp_path / "none.expect.toml")
