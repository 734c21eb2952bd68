"""What a run is asked for is checked before anything runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from suite_runs import limits, scene

from ghostball.model import Ball, GhostballError
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.results.store import ResultsError
from ghostball.validation.suite.plan import criteria_beside_paths
from ghostball.validation.suite.suite import run_suite
from ghostball.validation.truth.closed_forms import has_closed_form

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
        (Criteria(truth="closed-form"), "no closed form"),
    ],
)
def test_wrong_criteria_are_refused(tmp_path: Path, criteria: Criteria, message: str) -> None:
    # Two balls are hit at once, which no closed form covers.
    others = [Ball(id=str(y), position=(1.0, y)) for y in (-0.03, 0.03)]
    tied = scene().model_copy(update={"balls": (*scene().balls, *others)})
    assert not has_closed_form(tied)
    with pytest.raises(GhostballError, match=message):
        run_suite([tied], ["fake"], tmp_path / "out", criteria={"roll": criteria})
    assert not (tmp_path / "out").exists()


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
    bare = path.rename(tmp_path / "mine")  # any file that `select` takes for a scene
    assert criteria_beside_paths([str(bare)]) == found
