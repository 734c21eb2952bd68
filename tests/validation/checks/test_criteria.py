"""Criteria files: what is refused, which criterion wins, how a value is judged."""

from __future__ import annotations

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


def test_the_selector_with_most_settings_wins_whatever_the_order() -> None:
    general, special = (
        criterion("pymunk", at_most=1.0),
        criterion("pymunk:contact_steps=exact", at_most=2),
    )
    for both in (criteria(general, special), criteria(special, general)):
        assert both.applying_to("pymunk", EXACT) == (special,)
        assert both.applying_to("pymunk", FIXED) == (general,)
        assert both.applying_to("pybullet", FIXED) == ()


def test_a_special_criterion_replaces_a_general_one_of_another_kind() -> None:
    # Else "at most 1 m natively" would still bind where "at least 2 m" was meant to replace it.
    general = criterion("pymunk", at_most=1.0)
    special = criterion("pymunk:contact_steps=exact", at_least=2.0)
    assert criteria(general, special).applying_to("pymunk", EXACT) == (special,)


def test_precedence_is_per_metric() -> None:
    time = criterion("pymunk", metric="rest_time_error")
    special = criterion("pymunk:contact_steps=exact", at_most=2.0)
    assert set(criteria(time, special).applying_to("pymunk", EXACT)) == {time, special}


def test_a_range_is_two_criteria() -> None:
    low, high = criterion("pymunk", at_least=1.0), criterion("pymunk", at_most=2.0)
    assert criteria(low, high).applying_to("pymunk", FIXED) == (low, high)


def test_equally_specific_criteria_that_both_cover_an_engine_are_refused() -> None:
    both = criteria(
        criterion("pymunk:contact_steps=exact"), criterion("pymunk:dt=1e-3", at_most=2.0)
    )
    assert len(both.applying_to("pymunk", FIXED)) == 1
    with pytest.raises(CriteriaError, match=r"`rest_error_max`, equally specific.*one more"):
        both.applying_to("pymunk", EXACT)


def test_an_engine_that_nobody_installed_is_refused() -> None:
    with pytest.raises(CriteriaError, match=r'x.toml: `criteria\[0\].*"pimunk".*mean `pymunk`'):
        criteria(criterion("pimunk")).check_engines(["ghostball", "pymunk"], "x.toml")


def test_the_tables_of_steps_are_checked_too() -> None:
    for table in ("steps", "beyond_step"):
        row = {"engines": ["pimunk"], "reason": "because"}
        if table == "steps":
            row |= {"late": ["ball-ball"], "energy_noise": 1e-9}
        read = Criteria.model_validate({table: [row]})
        with pytest.raises(CriteriaError, match=rf"`{table}\[0\].*mean `pymunk`"):
            read.check_engines(["ghostball", "pymunk"], "x.toml")


RULE = """\
[[steps]]
engines = ["pymunk"]
late = ["ball-ball"]
energy_noise = 1e-9
reason = "by hand"
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"ball-ball"', '"bal-ball"', r"`steps\[0\].late\[0\]` must be .*got 'bal-ball'"),
        ("1e-9", "-1e-9", r"`steps\[0\].energy_noise` must be greater than 0, got -1e-09"),
        (
            "late",
            "lte",
            r"`steps\[0\].lte` is not a known field. Known here: engines, reason, late",
        ),
        ('reason = "by hand"', "", r"`steps\[0\].reason` is missing"),
        ('late = ["ball-ball"]', "", r"`steps\[0\].late` is missing"),
    ],
)
def test_a_wrong_rule_of_steps_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "shot.expect.toml"
    path.write_text(RULE.replace(old, new))
    with pytest.raises(CriteriaError, match=message):
        Criteria.load(path)


def test_every_engine_is_meant_by_a_star_and_one_that_is_named_is_meant_more() -> None:
    every, named = criterion("*"), criterion("pymunk", at_most=2.0)
    both = criteria(every, named)
    assert both.applying_to("mine", {}) == (every,)
    assert both.applying_to("pymunk", FIXED) == (named,)
    both.check_engines(["pymunk"], "x.toml")
    exact = Selector.parse("*:contact_steps=exact")
    assert exact.covers("mine", EXACT)
    assert not exact.covers("mine", FIXED)
    assert not exact.covers("mine", {})  # it has no such setting, and needs none


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


def test_an_engine_that_runs_nowhere_is_refused_with_the_line(tmp_path: Path) -> None:
    path = tmp_path / "shot.expect.toml"
    path.write_text(GOOD.replace('"pymunk"', '"pimunk"'))
    read = Criteria.load(path)
    with pytest.raises(CriteriaError, match="must name installed engines") as caught:
        read.check_engines(["ghostball", "pymunk", "pybullet"], "x.toml")
    assert str(caught.value).startswith(f"{path}:3: `criteria[0].engines`")
    assert "\n" not in str(caught.value)


GOOD = """
truth = "engine"
[[criteria]]
engines = ["pymunk", "pybullet:contact_steps=exact"]
metric = "collision_count"
equals = 3
reason = "counted by hand"
"""


def test_a_file_is_read_back(tmp_path: Path) -> None:
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


def test_a_scene_without_a_file_beside_it_has_no_criteria(tmp_path: Path) -> None:
    assert criteria_beside(tmp_path / "shot.toml") == Criteria()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"collision_count"', '"collision_cuont"', r"`criteria\[0\].metric` .*`collision_count`\?"),
        ("equals = 3", "", r"`criteria\[0\]` must give exactly one .* got none of them"),
        ("equals = 3", "equals = 3\nat_most = 4", r"exactly one .* got `at_most` and `equals`"),
        ("equals = 3", "equals = nan", r"`criteria\[0\].equals` .*got nan"),
        ("equals = 3", 'equals = "3"', r"`criteria\[0\].equals` .*got '3'"),
        ("equals = 3", "equals = true", r"`criteria\[0\].equals` .*got True"),
        ('"counted by hand"', '"  "', r"`criteria\[0\].reason` must not be blank"),
        ('reason = "counted by hand"', "", r"`criteria\[0\].reason` is missing"),
        ("reason =", "raeson =", r"`criteria\[0\].raeson` is not a known field"),
        ('truth = "engine"', 'truth = "guess"', r"`truth` must be .*got 'guess'"),
        (
            'truth = "engine"',
            "thruth = 1",
            r"`thruth` is not a known field.*truth, proved, criteria",
        ),
        (
            '["pymunk", "pybullet:contact_steps=exact"]',
            "[]",
            r"`criteria\[0\].engines` .*at least 1",
        ),
        ('"pymunk",', '"pymunk:fast",', r"engines\[0\]`: a setting must be `key=value`"),
        ('"pymunk",', "7,", r"`criteria\[0\].engines\[0\]` must be an engine's name"),
        ("equals = 3", "equals 3", r"not valid TOML: .*line 6"),
        ('"collision_count"', '"collisions"', r":3: `criteria\[0\].metric` must be a known metric"),
        (
            'metric = "collision_count"\nequals = 3',
            'metric = "accuracy"\nat_most = "nanometers"',
            r":3: `criteria\[0\]` must be a class of `accuracy`, got 'nanometers'. From",
        ),
        (
            "equals = 3",
            'equals = 3\nclaiming = "most"',
            r"`criteria\[0\].claiming` must be",
        ),
    ],
)
def test_a_wrong_file_is_refused_by_name_and_field(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    assert old in GOOD
    path = tmp_path / "shot.expect.toml"
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(CriteriaError, match=message) as caught:
        Criteria.load(path)
    assert str(path) in str(caught.value)


def test_an_excuse_names_whom_it_excuses(tmp_path: Path) -> None:
    # With "*" whoever calls a setting so would be held to nothing.
    path = tmp_path / "shot.expect.toml"
    path.write_text('[[excused]]\nengines = ["pymunk", "*:config=naive"]\nreason = "so"\n')
    with pytest.raises(
        CriteriaError, match=r":1: `excused\[0\]` must name .*got '\*:config=naive'"
    ):
        Criteria.load(path)


def test_a_repeated_criterion_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "shot.expect.toml"
    path.write_text(GOOD + GOOD.replace('truth = "engine"', "").replace("equals = 3", "equals = 4"))
    with pytest.raises(CriteriaError, match=r"`criteria\[1\]` repeats `equals` .* for `pymunk`"):
        Criteria.load(path)


def test_limits_out_of_order_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "shot.expect.toml"
    least = GOOD.replace('truth = "engine"', "").replace("equals = 3", "at_least = 4")
    path.write_text(GOOD + least)
    with pytest.raises(CriteriaError, match=r"in order, .*got equals 3, at_least 4") as found:
        Criteria.load(path)
    assert str(found.value).startswith(f"{path}:10: ")
    path.write_text(GOOD + least.replace("at_least = 4", "at_least = 3"))
    assert len(Criteria.load(path).criteria) == 2


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CriteriaError, match="can't read the criteria"):
        Criteria.load(tmp_path / "none.expect.toml")
