"""The arguments of a run are checked before any engine runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from suite_runs import limits, scene

from ghostball.engine.library import load
from ghostball.engine.library.entry import Entry
from ghostball.model import Ball, GhostballError
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.results.store import Results, ResultsError, ResultsWriter
from ghostball.validation.scenes.library import FULL, find_scene, select
from ghostball.validation.suite import case, suite
from ghostball.validation.suite.ensemble import Ensemble, PerturbationSize
from ghostball.validation.suite.plan import criteria_beside_paths, plan, shipped_criteria
from ghostball.validation.suite.suite import DEFAULT_ENGINES, run_suite
from ghostball.validation.truth import closed_forms
from ghostball.validation.truth.closed_forms import FORMS, may_have_closed_form

pytestmark = pytest.mark.usefixtures("fake_engines")


@pytest.mark.parametrize(
    ("engines", "message"),
    [
        (["fkae"], "mean `fake`"),
        (["fake:shfit=1"], "`shfit` is not a setting"),
        (["fake", "fake"], "each engine must be given once"),
        ([], "at least one engine"),
    ],
)
def test_wrong_engines_are_refused(tmp_path: Path, engines: list[str], message: str) -> None:
    with pytest.raises(GhostballError, match=message):
        run_suite([scene()], engines, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("criteria", "message"),
    [
        (limits("fkae"), "mean `fake`"),
        (limits("fake:shfit=1"), "names the setting `shfit`"),
        (Criteria(truth="closed-form"), "its values have no closed form"),
        (Criteria(truth="certified"), "it can't be certified"),
    ],
)
def test_wrong_criteria_are_refused(tmp_path: Path, criteria: Criteria, message: str) -> None:
    integrated = find_scene("cushion-mathavan")  # this law has no closed form and no proof
    with pytest.raises(GhostballError, match=message):
        run_suite([integrated], ["fake"], tmp_path / "out", criteria={integrated.name: criteria})
    assert not (tmp_path / "out").exists()


def test_a_closed_form_that_only_solving_rules_out_is_refused_before_a_shot_is_played(
    tmp_path: Path,
) -> None:
    """Fails if the error is raised case by case, or if earlier results are lost."""
    # Two balls are hit simultaneously, which no closed form covers.
    others = [Ball(id=str(y), position=(1.0, y)) for y in (-0.03, 0.03)]
    tied = scene("tied").model_copy(update={"balls": (*scene().balls, *others)})
    assert may_have_closed_form(tied)
    run_suite([scene()], ["fake"], tmp_path)
    with pytest.raises(GhostballError, match=r'"tied": its criteria say .* have no closed form'):
        run_suite(
            [scene(), tied],
            ["fake:does=crash"],
            tmp_path,
            criteria={"tied": Criteria(truth="closed-form")},
        )
    assert [case.scene for case in Results.open(tmp_path).cases] == ["roll"]


def test_planning_solves_proves_compiles_and_plays_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> Any:
        raise AssertionError("planning must not do this")

    forms = {name: form._replace(solve=refuse) for name, form in FORMS.items()}
    monkeypatch.setattr(closed_forms, "FORMS", forms)
    monkeypatch.setattr(closed_forms, "form_of_shape", refuse)
    monkeypatch.setattr("ghostball.validation.truth.certificates.certify", refuse)
    for name in ("__call__", "bind", "code_for"):  # these compile, load or call a kernel
        monkeypatch.setattr(Entry, name, refuse)
    monkeypatch.setattr(load, "build", refuse)
    closed_forms._solved.cache_clear()
    closed_forms.closed_form.cache_clear()
    scenes = select([FULL])
    given = {one.name: shipped_criteria(one) for one in scenes}
    for criteria in ({}, given):
        planned = plan(
            scenes, DEFAULT_ENGINES, criteria, None, ensemble=Ensemble(2, PerturbationSize())
        )
        assert planned.size == 3 * len(scenes) * len(DEFAULT_ENGINES)


def test_a_scene_is_planned_run_judged_and_stored_once_and_in_this_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    verbs: list[str] = []

    def watch(where: Any, verb: str) -> None:
        done = getattr(where, verb)

        def watched(*given: Any, **named: Any) -> Any:
            verbs.append(verb)
            return done(*given, **named)

        monkeypatch.setattr(where, verb, watched)

    for where, verb in (
        (suite, "plan"),
        (suite, "prepare"),
        (case, "truth_of"),
        (suite, "run_case"),
        (case, "judge"),
        (ResultsWriter, "write"),
    ):
        watch(where, verb)
    run_suite([scene()], ["fake"], tmp_path)
    assert verbs == ["plan", "prepare", "truth_of", "run_case", "judge", "write"]


def test_scenes_of_one_name_jobs_below_one_and_a_foreign_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(GhostballError, match="each scene must be given once, got roll"):
        run_suite([scene(), scene()], ["fake"], tmp_path / "out")
    with pytest.raises(GhostballError, match="`jobs` must be at least 1, got 0"):
        run_suite([scene()], ["fake"], tmp_path / "out", jobs=0)
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(ResultsError, match="not empty"):
        run_suite([scene()], ["fake:does=raise"], tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_an_engine_that_is_absent_needs_no_settings_for_its_criteria(tmp_path: Path) -> None:
    outcome = run_suite([scene()], ["absent"], tmp_path, criteria={"roll": limits("absent:dt=1")})
    assert outcome.cases[0].outcome == "unavailable"


def test_scenes_given_by_path_bring_the_criteria_beside_them(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    scene("by-path").save(path)
    (tmp_path / "mine.expect.toml").write_text('truth = "engine"\n')
    found = criteria_beside_paths(["smoke", "stop", str(path)])
    assert found == {"by-path": Criteria(truth="engine")}
    bare = path.rename(tmp_path / "mine")  # `select` accepts any file as a scene
    assert criteria_beside_paths([str(bare)]) == found
