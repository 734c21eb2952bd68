"""The lists of columns: what is refused in one, and that no engine is the truth of a column."""

from __future__ import annotations

import pytest

from ghostball.model import GhostballError
from ghostball.validation.board.asking import board_scene
from ghostball.validation.board.column import ACCURACY, COLUMNS, load_columns
from ghostball.validation.results.records import INDEPENDENT
from ghostball.validation.scenes.library import scene_names
from ghostball.validation.truth.scene_truth import truth_of

GOOD = 'id = "cut"\ntitle = "single collision"\nquestion = "How far off"\nmetric = "energy_drift"\n'
SCENES, LIMITS = 'scenes = ["throw"]\n', "good = 1e-4\nfair = 1e-2\n"

BESIDE = GOOD.replace("energy_drift", "likeness")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (GOOD + SCENES + "good = 1e-2\nfair = 1e-4\n", "`fair` must be at least `good`"),
        (GOOD + SCENES, "`good` must be given"),
        (GOOD + LIMITS, "column 'cut': `scenes` must name at least one, got none"),
        (GOOD + LIMITS + "scenes = []", "column 'cut': `scenes` must name at least one, got none"),
        (BESIDE + LIMITS, "metric 'likeness' must have no `fair`"),
        (BESIDE + SCENES, "metric 'likeness' must have no `scenes`"),
        (
            GOOD + LIMITS + 'scenes = ["trow"]',
            r"scenes\[0\]` must be a scene of .*'throw'",
        ),
        (GOOD + LIMITS + 'scenes = ["zz"]', r"Put a file zz\.toml there"),
        (
            GOOD.replace("drift", "drft") + SCENES + LIMITS,
            r"`column\[0\].metric` .*must be a known metric, got 'energy_drft'. Did you mean",
        ),
        (GOOD.replace("energy_drift", "zz") + SCENES + LIMITS, "Known metrics: rest_error_max"),
        (GOOD.replace("energy_drift", "accuracy") + SCENES + LIMITS, "must have no `good`"),
        (GOOD + SCENES + LIMITS + 'pick = "least"', "`pick` = 'least' or 'widest' must come"),
        (GOOD + SCENES + LIMITS + 'pick = "widest"', "'widest' must have the metric 'accuracy'"),
        (GOOD + SCENES + LIMITS + "above = 1.0", "`above` and `pick` = 'fastest' must come"),
        (GOOD + SCENES + LIMITS + "shade = 1", r"`column\[0\].shade` is not a known field"),
        (
            GOOD + SCENES + LIMITS + "settings = [{ step = -1.0 }]",
            r"settings\[0\].step`",
        ),
        (GOOD + SCENES + LIMITS + "[[column]]\n" + GOOD + SCENES + LIMITS, "must differ, got cut"),
        ("id = ", "can't read the columns: Invalid value"),
    ],
)
def test_a_list_that_breaks_a_rule_is_refused_in_one_line(tmp_path, text, says):
    path = tmp_path / "columns.toml"
    path.write_text("[[column]]\n" + text)
    with pytest.raises(GhostballError, match=says) as error:
        load_columns(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_a_list_that_keeps_them_is_read(tmp_path):
    path = tmp_path / "columns.toml"
    path.write_text("[[column]]\n" + GOOD + SCENES + LIMITS)
    (column,) = load_columns(path).values()
    assert (column.unit, column.good, column.fair) == ("", 1e-4, 1e-2)
    path.write_text("[[column]]\n" + BESIDE)
    (column,) = load_columns(path).values()
    assert (column.unit, column.scenes, column.good) == ("standard errors", (), None)
    with pytest.raises(GhostballError, match="can't read the columns"):
        load_columns(tmp_path / "nowhere.toml")


@pytest.mark.parametrize("physics", [{}, {"impacts": "sequential"}, {"motion": "sliding"}])
@pytest.mark.parametrize("name", [one.id for one in COLUMNS.values() if one.metric == ACCURACY])
def test_what_is_right_owes_nothing_to_an_engine_however_a_scene_is_played(name, physics):
    for scene in map(board_scene, COLUMNS[name].scenes):
        changes = dict(physics)
        if "motion" in physics and not scene.rolling_frictions.any():
            changes["sliding_friction"] = 0.0
        shot = scene.model_copy(update={"physics": scene.physics.model_copy(update=changes)})
        assert truth_of(shot).kind in INDEPENDENT


def test_scenes_have_the_names_of_their_files_and_of_no_shipped_one():
    for name in {name for column in COLUMNS.values() for name in column.scenes}:
        assert board_scene(name).name == name
        assert name not in scene_names()
