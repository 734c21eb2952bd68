"""Acceptance stores the results of a comparison with a reason; if refused, it writes nothing."""

from __future__ import annotations

from importlib import import_module

import gate
import pytest

from ghostball.model import GhostballError
from ghostball.validation.baselines.accept import CHANGES_FILE, AcceptError
from ghostball.validation.baselines.baseline import baseline_path
from ghostball.validation.baselines.gate import compared_run_in
from ghostball.validation.baselines.regression import load_regression, save_regressions


def test_one_of_two_changes_is_accepted_and_the_other_still_fails(accepted):
    accepted.plant({"cut": 1.01, "roll": 0.99})
    found = accepted.compare()
    assert {one.failed for one in found.scenes} == {True}
    done = accepted.accept("The cloth is faster.", only=["c*"])
    assert (done.written, done.left) == (("cut",), ("roll",))
    found = accepted.compare()
    assert gate.changes(found) == {"cut": "unchanged", "roll": "worse"}
    assert found.outcome == "failed"
    accepted.accept("This too.")
    found = accepted.compare()
    assert set(gate.changes(found).values()) == {"unchanged"}
    # Acceptance doesn't remove failed limits.
    assert found.outcome == "failed"
    assert all("failed limits: quality_factor must be" in one.summary for one in found.scenes)


@pytest.mark.parametrize("sources", ["0" * 64, None])
def test_a_comparison_of_other_code_is_not_accepted(shop, sources):
    found = shop.compare()
    head = {name: value for name, value in found.head.items() if name != "sources"}
    if sources is not None:
        head["sources"] = sources
    save_regressions([found.model_copy(update={"head": head})], shop.out)
    with pytest.raises(AcceptError, match="the code has changed since"):
        shop.accept()
    assert not shop.baselines.exists()


def test_a_baseline_that_is_not_the_one_that_was_compared_with_is_not_overwritten(accepted):
    # Another person's accepted baseline was pulled meanwhile, or `--baselines` names another
    # folder.
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
    with pytest.raises(AcceptError, match="differs from the baseline that was compared"):
        accepted.accept("Mine.")
    assert accepted.contents() == other != theirs
    baseline_path(accepted.baselines, "cut").unlink()
    with pytest.raises(AcceptError, match="differs from the baseline that was compared"):
        accepted.accept("Mine.")
    assert "cut.json" not in accepted.contents()


def test_results_that_are_not_those_that_were_compared_are_not_accepted(accepted):
    accepted.plant({"cut": 1.01})
    accepted.compare()
    found = load_regression(accepted.out)
    accepted.plant({"cut": 1.02})
    accepted.compare()
    save_regressions([found], accepted.out)
    before = accepted.contents()
    with pytest.raises(AcceptError, match=r"cut: .*isn't the one that was compared, so"):
        accepted.accept()
    assert accepted.contents() == before


def test_a_scene_that_the_results_hold_no_more_is_named(accepted):
    accepted.plant({"cut": 1.01})
    accepted.compare()
    found = load_regression(accepted.out)
    (cut,) = (one for one in found.scenes if one.scene == "cut")
    gone = cut.model_copy(update={"scene": "gone"})
    save_regressions([found.model_copy(update={"scenes": (gone,)})], accepted.out)
    with pytest.raises(
        GhostballError,
        match=r'"gone" was compared, but .* no longer has its '
        r"result",
    ):
        accepted.accept()


def test_only_what_is_asked_for_is_read_or_simulated_again(accepted, monkeypatch):
    asked = []

    def played(results, gate, scene):
        asked.append(scene)
        return compared_run_in(results, gate, scene)

    accepting = import_module("ghostball.validation.baselines.accept")  # not its function
    monkeypatch.setattr(accepting, "compared_run_in", played)
    accepted.plant({"cut": 1.01, "roll": 0.99})
    accepted.compare()
    assert accepted.accept(only=["cut"]).left == ("roll",)
    assert asked == ["cut"]
    # A scene that was accepted meanwhile isn't left over.
    assert accepted.accept(only=["roll"]).left == ()
    assert asked == ["cut", "roll"]


def test_the_changelog_has_the_newest_entry_on_top_and_keeps_the_others(accepted):
    changelog = accepted.baselines / CHANGES_FILE
    first = changelog.read_text("utf-8")
    assert first.startswith("# Accepted changes, with reasons\n")
    assert "New: cut, roll" in first
    changelog.write_text(first + "\nA note by hand.\n", "utf-8")
    accepted.plant({"cut": 1.01})
    accepted.compare()
    accepted.accept("A | in a reason.")
    text = changelog.read_text("utf-8")
    head, second, last = text.split("\n## ")
    assert head == first.split("\n## ")[0]
    assert "A | in a reason." in second
    assert "* cut: worse; " in second
    assert last == first.split("\n## ")[1] + "\nA note by hand.\n"
