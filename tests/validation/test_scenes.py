"""The shipped scenes: complete, valid, as stated in their titles; and the ways to find them."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from engine import Scene, SceneError, simulate
from engine._scene_file import json_schema
from reference_adapters.registry import engine_names
from validation.closed_forms import FORMS, closed_form
from validation.criteria import SUFFIX, Criteria, criteria_beside
from validation.library import FOLDER, find_scene, scene_names, select, shipped_scenes
from validation.metrics import matching_collisions
from validation.truth import collisions_of

NAMES = scene_names()
SCHEMA_LINE = "#:schema ./scene.schema.json"

PROBES = {
    "stop": {"stop"},
    "head-on": {"head-on"},
    "half-ball": {"half-ball-cut"},
    "thin cut": {"thin-cut"},
    "unequal masses and radii": {"unequal-balls"},
    "wall bounce": {"wall-bounce"},
    "corner double bounce": {"corner-double-bounce"},
    "three-ball chain": {"three-ball-chain"},
    "moving-moving": {"moving-moving"},
    "Figure 4": {"figure4-head-on", "figure4-skewed"},
    "chaos pair": {"chaos-a", "chaos-b"},
    "breaks": {"break-7", "break-8", "break-16"},
    "Galperin": {f"galperin-{k}" for k in range(5)},
    "gas": {"elastic-gas"},
}


def gaps(scene: Scene) -> dict[tuple[int, int], float]:
    positions, radii = scene.positions[:, :2], scene.radii
    return {
        (a, b): float(np.hypot(*(positions[a] - positions[b])) - radii[a] - radii[b])
        for a, b in itertools.combinations(range(len(radii)), 2)
    }


def test_everything_promised_is_there() -> None:
    assert len(NAMES) >= 16
    for probe, names in PROBES.items():
        assert names <= set(NAMES), probe


def test_every_closed_form_belongs_to_a_scene() -> None:
    assert set(FORMS) <= set(NAMES)


@pytest.mark.parametrize("path", shipped_scenes(), ids=lambda path: path.stem)
def test_scene_file(path: Path, tmp_path: Path) -> None:
    scene = Scene.load(path)
    assert scene.name == path.stem
    assert scene.title
    assert path.read_text(encoding="utf-8").startswith(SCHEMA_LINE + "\n#")
    # Saved and read again it is the same scene, to the last bit.
    scene.save(tmp_path / "copy.toml")
    assert Scene.load(tmp_path / "copy.toml") == scene
    assert ("closed-form" in scene.tags) == (closed_form(scene) is not None)
    assert ("break" in scene.tags) == (len(scene.balls) >= 7 and "rack gap" in scene.title)


def test_titles_differ() -> None:
    titles = [scene.title for scene in select()]
    assert len(set(titles)) == len(titles)


def test_schema_beside_the_scenes_is_current() -> None:
    # Mend with: python -c "from engine._scene_file import json_schema; print(json_schema())"
    # > validation/scenes/scene.schema.json
    assert (FOLDER / "scene.schema.json").read_text(encoding="utf-8") == json_schema() + "\n"


@pytest.mark.parametrize("scene", select(["break"]), ids=lambda scene: scene.name)
def test_racks_have_the_gap_that_their_title_states(scene: Scene) -> None:
    stated = float(re.search(r"rack gap ([\d.]+) mm", scene.title)[1]) * 1e-3  # type: ignore[index]
    in_rack = [gap for (a, _), gap in gaps(scene).items() if a > 0]
    neighbours = [gap for gap in in_rack if gap < 0.01]
    # Positions are given to 0.1 um.
    np.testing.assert_allclose(neighbours, stated, rtol=0, atol=2e-7)
    # A cue ball on the axis of the rack would make ties.
    middle = np.mean(scene.positions[1:, 1])
    assert abs(scene.positions[0, 1] - middle) > 1e-3


def test_chain_has_the_gap_that_its_title_states() -> None:
    scene = find_scene("three-ball-chain")
    assert "gap 1 mm" in scene.title
    assert gaps(scene)[1, 2] == pytest.approx(1e-3, abs=1e-12)


def test_half_ball_cut_aims_at_the_edge() -> None:
    scene = find_scene("half-ball-cut")
    offset = scene.positions[1, 1] - scene.positions[0, 1]
    assert offset == pytest.approx(scene.balls[0].radius, rel=1e-12)


def test_galperin_masses_and_cushion() -> None:
    for k in range(5):
        scene = find_scene(f"galperin-{k}")
        small, large = scene.balls
        assert large.mass == small.mass * 100**k
        assert scene.table is not None
        assert scene.table.cushions == ("left",)
        assert scene.physics.rolling_friction == 0.0


def test_chaos_pair_differs_by_1e_4_and_ends_elsewhere() -> None:
    a, b = find_scene("chaos-a"), find_scene("chaos-b")
    assert b.balls[1:] == a.balls[1:]
    assert (b.table, b.physics) == (a.table, a.physics)
    np.testing.assert_array_equal(a.positions, b.positions)
    assert np.hypot(*(b.velocities - a.velocities)[0, :2]) == pytest.approx(1e-4, rel=1e-9)
    # The paper, section 4.2: "vastly change the final resting state".
    apart = np.linalg.norm(simulate(a).rest_positions - simulate(b).rest_positions, axis=1)
    assert apart.max() > 0.1


def test_figure_4_differs_in_the_point_of_impact_alone() -> None:
    straight, skewed = find_scene("figure4-head-on"), find_scene("figure4-skewed")
    assert skewed.balls[1] == straight.balls[1]
    np.testing.assert_array_equal(skewed.velocities, straight.velocities)
    assert straight.positions[0, 1] == straight.positions[1, 1]
    assert skewed.positions[0, 1] - skewed.positions[1, 1] == pytest.approx(0.01)


# --- criteria


@pytest.mark.parametrize("path", shipped_scenes(), ids=lambda path: path.stem)
def test_every_scene_has_criteria(path: Path) -> None:
    # Criteria.load refuses unknown metrics and empty reasons; check_engines unknown engines.
    criteria = criteria_beside(path)
    criteria.check_engines(engine_names(), str(path))
    has_form = closed_form(Scene.load(path)) is not None
    assert criteria.truth == ("closed-form" if has_form else "engine")
    assert criteria.criteria
    for criterion in criteria.criteria:
        assert criterion.reason.endswith("."), criterion.reason
        assert len(criterion.reason) > 20, criterion.reason


def test_no_criteria_without_a_scene() -> None:
    beside = {path.name.removesuffix(SUFFIX) for path in FOLDER.glob(f"*{SUFFIX}")}
    assert beside == set(NAMES)


@pytest.mark.parametrize("name", sorted(FORMS))
def test_our_engine_is_held_to_rounding_where_there_is_a_closed_form(name: str) -> None:
    scene = find_scene(name)
    if scene.physics.motion == "sliding":
        pytest.skip("our engine does not represent sliding")
    criteria = Criteria.load(FOLDER / f"{name}{SUFFIX}")
    metrics = {criterion.metric for criterion in criteria.applying_to("ghostball", {})}
    assert {"rest_error_ulps", "matching_events"} <= metrics
    assert {"ball_ball_count", "ball_cushion_count"} <= metrics


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["break-7", "break-8", "break-16", "chaos-a", "chaos-b", "elastic-gas"]
)
def test_limits_on_landed_engines_are_what_a_landing_gap_costs(name: str) -> None:
    # Their reasons say how far a nudge of 1e-10 m is seen: a seeded rerun must stay within them.
    scene = find_scene(name)
    criteria = Criteria.load(FOLDER / f"{name}{SUFFIX}")
    limits = {
        criterion.metric: criterion.limit
        for criterion in criteria.applying_to("pymunk", {"mode": "landed", "config": "tuned"})
    }
    exact = simulate(scene, record="events")
    collisions, times = collisions_of(exact.events)
    random = np.random.default_rng(5)
    for _ in range(20):
        nudge = random.uniform(-1e-10, 1e-10, (len(scene.balls), 2))
        balls = tuple(
            ball.model_copy(update={"position": (*(ball.position[:2] + by), ball.position[2])})
            for ball, by in zip(scene.balls, nudge, strict=True)
        )
        nudged = simulate(scene.model_copy(update={"balls": balls}), record="events")
        matched = matching_collisions(*collisions_of(nudged.events), collisions, times)
        assert matched >= limits["matching_events"]
        apart = np.linalg.norm(nudged.rest_positions - exact.rest_positions, axis=1).max()
        assert apart <= limits.get("rest_error_max", np.inf)


# --- finding scenes


def test_find_by_name_and_by_path(tmp_path: Path) -> None:
    scene = find_scene("stop")
    assert scene.name == "stop"
    scene.save(tmp_path / "mine.toml")
    assert find_scene(tmp_path / "mine.toml") == scene
    assert find_scene(str(tmp_path / "mine.toml")) == scene


def test_unknown_name_offers_near_ones() -> None:
    with pytest.raises(SceneError, match=r'unknown scene "half-ball".*half-ball-cut'):
        find_scene("half-ball")
    with pytest.raises(SceneError, match=r'unknown scene "qqqq".*Known: around-the-table'):
        find_scene("qqqq")


def test_missing_file_says_so() -> None:
    with pytest.raises(SceneError, match=r"no-such\.toml: can't read the scene"):
        find_scene("no-such.toml")


def test_select_suites() -> None:
    assert [scene.name for scene in select()] == list(NAMES)
    smoke = select(suite="smoke")
    assert 0 < len(smoke) < len(NAMES)
    assert all("smoke" in scene.tags for scene in smoke)


def test_select_by_name_tag_and_path(tmp_path: Path) -> None:
    find_scene("stop").model_copy(update={"name": "mine"}).save(tmp_path / "mine.toml")
    chosen = select(["galperin", "stop", str(tmp_path / "mine.toml"), "galperin-1"])
    assert [scene.name for scene in chosen] == [
        *(f"galperin-{k}" for k in range(5)),
        "stop",
        "mine",
    ]


def test_select_refuses_what_it_can_t_find() -> None:
    with pytest.raises(SceneError, match=r'unknown scene or tag "galprin".*galperin'):
        select(["galprin"])


def test_select_refuses_two_scenes_of_one_name(tmp_path: Path) -> None:
    other = find_scene("stop").model_copy(update={"title": "another"})
    other.save(tmp_path / "stop.toml")
    with pytest.raises(SceneError, match=r'two different ones are called "stop"'):
        select(["stop", str(tmp_path / "stop.toml")])


def test_criteria_files_are_no_scenes() -> None:
    assert not any(name.endswith(".expect") for name in NAMES)
