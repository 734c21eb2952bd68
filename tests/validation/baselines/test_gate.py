"""A folder of results against baselines: from none there to a planted change that is accepted."""

from __future__ import annotations

import re
from dataclasses import replace

import gate
import pytest

import ghostball.reference_adapters.ghostball
import ghostball.validation.runs.our_run
from ghostball.engine import simulate
from ghostball.model import UnsupportedSceneError
from ghostball.validation.baselines import gate as gate_module
from ghostball.validation.baselines.accept import (
    CHANGES_FILE,
    AcceptError,
    LimitsBrokenError,
    NotDeterministicError,
    accept,
)
from ghostball.validation.baselines.baseline import (
    load_baseline,
)
from ghostball.validation.baselines.gate import check_baselines, compare_results, outcome_of
from ghostball.validation.baselines.places import (
    BaselineError,
    baseline_names,
    baseline_path,
)
from ghostball.validation.baselines.regression import Regression, load_regression, save_regressions
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.results.store import Results
from ghostball.validation.suite.suite import run_suite

SCENES = [gate.cut_shot(), gate.roll_shot()]


class Workshop:
    """A folder of results and one of baselines."""

    def __init__(self, place, monkeypatch):
        self.out, self.baselines = place / "out", place / "accepted"
        self._monkeypatch = monkeypatch

    def compare(self, *, scenes=SCENES, **options) -> Regression:
        """Run the scenes, compare, and store what was found."""
        ours = Criteria(truth="engine")  # nothing here needs a proof
        criteria = {scene.name: ours for scene in scenes}
        run_suite(scenes, ["ghostball"], self.out, criteria=criteria)
        options = {"whole": False, **options}
        found = compare_results(Results.open(self.out), self.baselines, **options)
        save_regressions([found], self.out)
        return found

    def accept(self, reason="It is right.", **options):
        # What is planted breaks limits of truth, which is what acceptance is mostly not about.
        options = {"even_though_limits_fail": True, **options}
        return accept(self.out, reason, folder=self.baselines, **options)

    def plant(self, speeds):
        """Make our engine play the named scenes at another speed of the cue ball."""

        def planted(scene, **options):
            factor = speeds.get(scene.name, 1.0)
            cue, *others = scene.balls
            vx, vy, _ = cue.velocity
            moved = cue.model_copy(update={"velocity": (vx * factor, vy, 0.0)})
            if factor != 1.0:
                rolls = {"angular_velocity": (-vy / cue.radius, vx * factor / cue.radius, 0.0)}
                moved = moved.model_copy(update=rolls)
            result = simulate(scene.model_copy(update={"balls": (moved, *others)}), **options)
            return replace(result, scene=scene)

        for module in (ghostball.reference_adapters.ghostball, ghostball.validation.runs.our_run):
            self._monkeypatch.setattr(module, "simulate", planted)

    def contents(self):
        return {path.name: path.read_bytes() for path in self.baselines.glob("*")}

    @property
    def candidates(self):
        found = load_regression(self.out)
        return tuple(one.scene for one in found.scenes if one.candidate)


@pytest.fixture
def shop(tmp_path, monkeypatch, in_this_process):
    # The two shots of many balls take a second each, and are tested where they are shipped.
    monkeypatch.setattr(gate_module, "many_ball_scenes", lambda: ())
    return Workshop(tmp_path, monkeypatch)


@pytest.fixture
def accepted(shop):
    """A workshop whose baselines are accepted."""
    shop.compare()
    shop.accept("The first.")
    return shop


def changes(regression):
    return {one.scene: one.change for one in regression.scenes}


# --- from none to all -------------------------------------------------------------------------


def test_no_baseline_is_no_pass_until_it_is_accepted(shop):
    first = shop.compare()
    assert first.outcome == "no-baseline"
    assert changes(first) == {"cut": "no-baseline", "roll": "no-baseline"}
    assert shop.candidates == ("cut", "roll")
    assert not shop.baselines.exists(), "written without a reason"
    done = shop.accept("The  first\nof all.")
    assert (done.written, done.deleted, done.left) == (("cut", "roll"), (), ())
    baseline = load_baseline(baseline_path(shop.baselines, "cut"))
    assert baseline.accepted.reason == "The first of all."
    second = shop.compare()
    assert second.outcome == "passed"
    assert changes(second) == {"cut": "identical", "roll": "identical"}
    assert shop.candidates == ()
    assert second.base["reason"] == "The first of all."


def test_a_planted_change_fails_and_is_reported_with_its_first_event(accepted):
    accepted.plant({"cut": 1.01})
    found = accepted.compare()
    assert found.outcome == "failed"
    assert changes(found) == {"cut": "worse", "roll": "identical"}
    cut = found.scene("cut")
    assert cut.failed
    assert cut.first_difference.index == 0
    assert "cue meets object" in cut.first_difference.words
    assert cut.command == "ghostball regress ./cut.toml"
    assert cut.base_hash != cut.head_hash
    assert accepted.candidates == ("cut",)


def test_one_of_two_changes_is_accepted_and_the_other_still_fails(accepted):
    accepted.plant({"cut": 1.01, "roll": 0.99})
    found = accepted.compare()
    assert {one.failed for one in found.scenes} == {True}
    done = accepted.accept("The cloth is faster.", only=["c*"])
    assert (done.written, done.left) == (("cut",), ("roll",))
    found = accepted.compare()
    assert changes(found) == {"cut": "identical", "roll": "worse"}
    assert found.outcome == "failed"
    accepted.accept("This too.")
    found = accepted.compare()
    assert set(changes(found).values()) == {"identical"}
    # What the truth says of it can't be accepted.
    assert found.outcome == "failed"
    assert all("breaks its limits: quality_factor must be" in one.summary for one in found.scenes)


def test_a_counter_that_moved_fails_with_the_same_bits(accepted, monkeypatch):
    def busier(scene, **options):
        result = simulate(scene, **options)
        return replace(result, work={**result.work, "events": result.work["events"] + 1})

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", busier)
    found = accepted.compare()
    assert found.outcome == "failed"
    assert set(changes(found).values()) == {"identical"}
    assert accepted.candidates == ("cut", "roll")
    accepted.accept("Counts one more.")
    assert accepted.compare().outcome == "passed"


def test_a_metric_that_only_warns_passes_with_a_warning(accepted, monkeypatch):
    path = baseline_path(accepted.baselines, "roll")
    baseline = load_baseline(path)
    work = {
        name: value.model_copy(update={"level": "warn"}) for name, value in baseline.work.items()
    }
    path.write_text(baseline.model_copy(update={"work": work}).text(), encoding="utf-8")

    def busier(scene, **options):
        result = simulate(scene, **options)
        more = {"events": result.work["events"] + (scene.name == "roll")}
        return replace(result, work={**result.work, **more})

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", busier)
    found = accepted.compare()
    assert found.outcome == "passed"
    (warning,) = found.warnings
    assert warning.startswith("roll: `events` 1 -> 2")
    # ... and keeps its level when that is accepted.
    accepted.accept("Counts one more.")
    assert load_baseline(path).work["events"].level == "warn"
    assert load_baseline(path).work["events"].value == 2


def test_another_scene_of_the_same_name_is_not_comparable(accepted):
    changed = gate.cut_shot(1.5)
    found = accepted.compare(scenes=[changed, SCENES[1]])
    assert changes(found) == {"cut": "not-comparable", "roll": "identical"}
    assert found.outcome == "no-baseline"
    accepted.accept("Another shot.")
    assert accepted.compare(scenes=[changed, SCENES[1]]).outcome == "passed"


def test_a_baseline_of_another_version_is_not_comparable_and_not_overwritten(accepted):
    path = baseline_path(accepted.baselines, "cut")
    path.write_text(path.read_text("utf-8").replace("schema = 3", "schema = 2"), "utf-8")
    check_baselines(accepted.baselines, ["cut"])
    before = accepted.contents()
    found = accepted.compare()
    assert found.outcome == "no-baseline"
    assert "`schema` must be 3, got 2" in found.scene("cut").summary
    assert accepted.contents() == before
    accepted.accept("Of this version.")
    assert accepted.compare().outcome == "passed"


def test_a_run_that_crashed_fails(accepted, monkeypatch):
    def crash(scene, **options):
        if scene.name == "cut":
            raise ZeroDivisionError("planted")
        return simulate(scene, **options)

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", crash)
    found = accepted.compare()
    cut = found.scene("cut")
    assert (cut.change, cut.failed) == ("worse", True)
    assert "planted" in cut.summary
    assert found.outcome == "failed"
    assert accepted.candidates == ()
    with pytest.raises(AcceptError, match="planted"):
        accepted.accept()


def refuse_rolling(monkeypatch):
    """Take a capability away from our engine."""

    def refuse(scene, **options):
        if scene.name == "roll":
            raise UnsupportedSceneError("ghostball", ("planted: no cloth without a table",))
        return simulate(scene, **options)

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", refuse)


def test_a_scene_that_our_engine_no_longer_represents_fails(accepted, monkeypatch):
    # Else a capability that was lost would pass, and its baseline would be removed as stale.
    refuse_rolling(monkeypatch)
    found = accepted.compare(whole=True)
    roll = found.scene("roll")
    assert (roll.change, roll.failed) == ("worse", True)
    assert "no cloth without a table" in roll.summary
    assert found.stale == ()
    assert found.outcome == "failed"


def test_nothing_that_was_compared_is_no_pass():
    assert outcome_of([]) == "no-baseline"


# --- stale ------------------------------------------------------------------------------------


def test_a_baseline_of_a_scene_that_is_no_more_is_reported_and_removed_when_accepted(accepted):
    one = [SCENES[0]]
    assert accepted.compare(scenes=one).stale == (), "only a part was run"
    found = accepted.compare(scenes=one, whole=True)
    assert found.stale == ("roll",)
    assert found.outcome == "passed"
    assert any("no more: roll" in warning for warning in found.warnings)
    done = accepted.accept("Rolling is gone.")
    assert (done.written, done.deleted) == ((), ("roll",))
    assert baseline_names(accepted.baselines) == ("cut",)
    assert "No more: roll." in (accepted.baselines / CHANGES_FILE).read_text("utf-8")
    # A second time there is nothing to remove, and nothing is written.
    before = accepted.contents()
    with pytest.raises(AcceptError, match='nothing to accept matches "\\*"'):
        accepted.accept("Again.")
    assert accepted.contents() == before


# --- what is refused --------------------------------------------------------------------------


def test_nonsense_is_refused_before_anything_runs(accepted):
    path = baseline_path(accepted.baselines, "cut")
    path.write_text(path.read_text("utf-8").replace('"error"', '"fatal"', 1), "utf-8")
    with pytest.raises(BaselineError, match=re.escape(str(path))):
        check_baselines(accepted.baselines, ["roll", "cut"])
    check_baselines(accepted.baselines, ["roll", "none"])


@pytest.fixture
def unsteady(monkeypatch):
    """Our engine says each time that the balls rest a nanometre farther."""
    count = iter(range(1, 99))

    def unsteady(scene, **options):
        result = simulate(scene, **options)
        state = result.final_state
        moved = state._replace(positions=state.positions + 1e-9 * next(count))
        return replace(result, final_state=moved)

    for module in (ghostball.reference_adapters.ghostball, ghostball.validation.runs.our_run):
        monkeypatch.setattr(module, "simulate", unsteady)


def test_an_engine_that_gives_other_bits_each_time_is_reported(accepted, unsteady):
    before = {path: path.read_bytes() for path in accepted.baselines.iterdir()}
    found = accepted.compare()
    assert found.outcome == "failed"
    assert [(one.change, one.candidate) for one in found.scenes] == [("not-deterministic", "")] * 2
    assert "played a second time, it gave other bits" in found.scenes[0].summary
    with pytest.raises(NotDeterministicError, match="each time that it plays cut, roll"):
        accepted.accept()
    with pytest.raises(NotDeterministicError, match="each time that it plays roll:"):
        accepted.accept(only=["roll"])
    assert {path: path.read_bytes() for path in accepted.baselines.iterdir()} == before


# --- accept -----------------------------------------------------------------------------------


@pytest.mark.parametrize("reason", ["", " \n\t "])
def test_nothing_is_accepted_without_a_reason(shop, reason):
    shop.compare()
    with pytest.raises(AcceptError, match="`reason` must say why"):
        shop.accept(reason)
    assert not shop.baselines.exists()


def test_nothing_is_accepted_that_was_not_compared(shop, tmp_path):
    with pytest.raises(AcceptError, match=r"holds no comparison.*`ghostball regress`"):
        shop.accept()
    assert not shop.baselines.exists()


@pytest.mark.parametrize("sources", ["0" * 64, None])
def test_a_comparison_of_other_code_is_not_accepted(shop, sources):
    found = shop.compare()
    head = {name: value for name, value in found.head.items() if name != "sources"}
    if sources is not None:
        head["sources"] = sources
    save_regressions([found.model_copy(update={"head": head})], shop.out)
    with pytest.raises(AcceptError, match="the code changed since"):
        shop.accept()
    assert not shop.baselines.exists()


def test_what_breaks_limits_of_truth_is_refused_and_named(accepted):
    accepted.plant({"cut": 1.0 + 1e-3})
    found = accepted.compare()
    assert [one.scene for one in found.broken] == ["cut"]
    before = accepted.contents()
    with pytest.raises(
        LimitsBrokenError, match=r"cut: quality_factor must be <= 32, got"
    ) as refused:
        accepted.accept(even_though_limits_fail=False)
    assert "roll" not in str(refused.value)
    assert accepted.contents() == before
    assert [one.scene for one in accepted.accept("A lesson.").broken] == ["cut"]


def test_a_baseline_that_is_not_the_one_that_was_compared_with_is_not_overwritten(accepted):
    # Someone else's acceptance, pulled in between, or another `--baselines`.
    accepted.plant({"cut": 1.01})
    accepted.compare()
    accepted.accept("The first.")
    other = accepted.contents()
    accepted.plant({"cut": 1.02})
    accepted.compare()
    accepted.accept("Theirs.")
    theirs = accepted.contents()
    accepted.plant({"cut": 1.03})
    accepted.compare()
    for name, content in other.items():
        (accepted.baselines / name).write_bytes(content)
    with pytest.raises(AcceptError, match="isn't what was compared with"):
        accepted.accept("Mine.")
    assert accepted.contents() == other != theirs
    baseline_path(accepted.baselines, "cut").unlink()
    with pytest.raises(AcceptError, match="isn't what was compared with"):
        accepted.accept("Mine.")
    assert "cut.toml" not in accepted.contents()


def test_the_changelog_has_the_newest_entry_on_top_and_keeps_the_others(accepted):
    changelog = accepted.baselines / CHANGES_FILE
    first = changelog.read_text("utf-8")
    assert first.startswith("# What was accepted, and why\n")
    assert "New: cut, roll." in first
    changelog.write_text(first + "\nA note by hand.\n", "utf-8")
    accepted.plant({"cut": 1.01})
    accepted.compare()
    accepted.accept("A | in a reason.")
    text = changelog.read_text("utf-8")
    head, second, last = text.split("\n## ")
    assert head == first.split("\n## ")[0]
    assert "A | in a reason." in second
    assert "| cut | worse |" in second
    assert last == first.split("\n## ")[1] + "\nA note by hand.\n"
    rows = [line for line in second.splitlines() if line.startswith("|")]
    assert all(row.count("|") == 4 for row in rows)
