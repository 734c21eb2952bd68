"""The shipped scenes are complete, valid and as titled; names, tags and paths find them."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ghostball.model import Scene, SceneError
from ghostball.model.scene import json_schema
from ghostball.reference_adapters.registry import engine_names
from ghostball.validation.checks.criteria import criteria_beside, shared_criteria
from ghostball.validation.scenes.library import (
    BOARD,
    CRITERIA_SUFFIX,
    FOLDER,
    find_scene,
    scene_names,
    scene_path,
    select,
    shipped_scenes,
)
from ghostball.validation.truth.certificates import certificate_of
from ghostball.validation.truth.closed_forms import FORMS, has_closed_form

NAMES = tuple(scene.name for scene in select())
ON_BOARD = [path for path in shipped_scenes() if path.parent.name == BOARD]
OF_SUITE = [path for path in shipped_scenes() if path not in ON_BOARD]

RESTING_CONTACT = {"push", "push-unequal", "wedged"}
"""Scenes with a closed form in which a force holds balls in contact."""


def gaps(scene: Scene) -> dict[tuple[int, int], float]:
    positions, radii = scene.positions[:, :2], scene.radii
    return {
        (a, b): float(np.hypot(*(positions[a] - positions[b])) - radii[a] - radii[b])
        for a, b in itertools.combinations(range(len(radii)), 2)
    }


def test_every_closed_form_belongs_to_a_scene() -> None:
    assert set(FORMS) <= set(NAMES)


@pytest.mark.parametrize("path", shipped_scenes(), ids=lambda path: path.stem)
def test_scene_file(path: Path, tmp_path: Path) -> None:
    scene = Scene.load(path)
    assert scene.name == path.stem
    assert scene.title
    where = ".." if path in ON_BOARD else "."
    assert path.read_text("utf-8").startswith(f"#:schema {where}/scene.schema.json\n")
    # A saved scene reads back to the last bit.
    scene.save(tmp_path / "copy.toml")
    assert Scene.load(tmp_path / "copy.toml") == scene
    assert ("closed-form" in scene.tags) == (has_closed_form(scene) and path in OF_SUITE)
    assert ("break" in scene.tags) == (len(scene.balls) >= 7 and "rack gap" in scene.title)


def test_schema_beside_the_scenes_is_current() -> None:
    # To renew the file: ghostball scenes --schema > validation/scenes/scene.schema.json
    assert (FOLDER / "scene.schema.json").read_text(encoding="utf-8") == json_schema() + "\n"


@pytest.mark.parametrize("scene", select(["break"]), ids=lambda scene: scene.name)
def test_racks_have_the_gap_that_their_title_states(scene: Scene) -> None:
    stated = float(re.search(r"rack gap ([\d.]+) mm", scene.title)[1]) * 1e-3  # type: ignore[index]
    in_rack = [gap for (a, _), gap in gaps(scene).items() if a > 0]
    neighbours = [gap for gap in in_rack if gap < 0.01]
    # The positions in the file are rounded to 0.1 um.
    np.testing.assert_allclose(neighbours, stated, rtol=0, atol=2e-7)
    # A cue ball on the axis of the rack would cause ties.
    middle = np.mean(scene.positions[1:, 1])
    assert abs(scene.positions[0, 1] - middle) > 1e-3


def test_half_ball_cut_aims_at_the_edge() -> None:
    scene = find_scene("half-ball-cut")
    offset = scene.positions[1, 1] - scene.positions[0, 1]
    assert offset == pytest.approx(scene.balls[0].radius, rel=1e-12)


# --- criteria


@pytest.mark.parametrize("path", OF_SUITE, ids=lambda path: path.stem)
def test_every_scene_has_criteria(path: Path) -> None:
    # Criteria.load refuses unknown metrics and empty reasons; check_engines unknown engines.
    criteria = criteria_beside(path)
    criteria.check_engines(engine_names(), str(path))
    scene = Scene.load(path)
    if has_closed_form(scene):
        assert criteria.truth == "closed-form"
    else:
        proof, _ = certificate_of(scene)
        whole = proof is not None and proof.proved
        assert criteria.truth in (("certified",) if whole else ("engine", "integration"))
    assert criteria.criteria
    for criterion in criteria.criteria:
        assert criterion.reason.endswith("."), criterion.reason
        assert len(criterion.reason) > 20, criterion.reason


def test_no_criteria_without_a_scene() -> None:
    beside = {
        path.name.removesuffix(CRITERIA_SUFFIX) for path in FOLDER.glob(f"*{CRITERIA_SUFFIX}")
    }
    assert beside == {*NAMES, "common", "relations", "shared"}


def test_shared_criteria_name_scenes_that_there_are() -> None:
    named = {name for one in shared_criteria().criteria for name in one.scenes}
    assert named <= set(NAMES)
    for one in shared_criteria().criteria:
        assert list(one.scenes) == sorted(set(one.scenes)), one.metric


@pytest.mark.parametrize(
    "name",
    # The two omitted scenes are each about one law, and have limits for its effect.
    sorted({one.name for one in select(["closed-form"])} - {"cloth-frictionless", "coulomb-cut"}),
)
def test_our_engine_is_held_to_rounding_where_there_is_a_closed_form(name: str) -> None:
    # Our engine integrates resting contacts in steps with a tolerance in metres.
    rest = "rest_error_max" if name in RESTING_CONTACT else "rest_error_ulps"
    criteria = criteria_beside(FOLDER / f"{name}.toml")
    metrics = {criterion.metric for criterion in criteria.applying_to("ghostball", {})}
    assert {rest, "matching_events", "ball_ball_count", "ball_cushion_count"} <= metrics


# --- finding scenes


def test_find_by_name_and_by_path(tmp_path: Path) -> None:
    scene = find_scene("stop")
    assert scene.name == "stop"
    scene.save(tmp_path / "mine.toml")
    assert find_scene(tmp_path / "mine.toml") == scene
    assert find_scene(str(tmp_path / "mine.toml")) == scene


def test_the_board_is_asked_for_by_its_tag_alone() -> None:
    board = select([BOARD])
    assert [scene.name for scene in board] == [path.stem for path in ON_BOARD]
    assert not {scene.name for scene in board} & set(NAMES)
    reported = select(["reported"])
    assert 0 < len(reported) < len(board)
    for scene in reported:
        assert "\n# Reported: https://github.com/" in scene_path(scene.name).read_text("utf-8")
    assert scene_names() == (*NAMES, *(scene.name for scene in board))


def test_scenes_are_selected_by_name_tag_and_path(tmp_path: Path) -> None:
    assert select(["full"]) == select()
    smoke = select(["smoke"])
    assert 0 < len(smoke) < len(NAMES)
    assert all("smoke" in scene.tags for scene in smoke)
    find_scene("stop").model_copy(update={"name": "mine"}).save(tmp_path / "mine.toml")
    chosen = select(["galperin", "stop", str(tmp_path / "mine.toml"), "galperin-1"])
    names = [*(f"galperin-{k}" for k in range(4)), "stop", "mine"]
    assert [scene.name for scene in chosen] == names


@pytest.mark.parametrize(
    ("find", "name", "message"),
    [
        (find_scene, "half-ball", r'unknown scene "half-ball".*half-ball-cut'),
        (find_scene, "qqqq", r'unknown scene "qqqq".*`ghostball scenes` lists them'),
        (select, ["galprin"], r'unknown scene or tag "galprin".*galperin'),
        (select, ["stop", "stop.toml"], r'two different ones are called "stop"'),
    ],
)
def test_a_scene_that_cannot_be_found_is_refused(
    find: Callable[[Any], Any],
    name: object,
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    find_scene("stop").model_copy(update={"title": "another"}).save(tmp_path / "stop.toml")
    with pytest.raises(SceneError, match=message):
        find(name)
