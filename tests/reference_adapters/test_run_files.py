"""Run files: invalid runs, and runs that don't fit their scene, are rejected with the location."""

from __future__ import annotations

import json

import pytest
from damage import faults, reads, texts

from ghostball.model import Scene
from ghostball.model.scene.obstacles import FIRST_POST
from ghostball.reference_adapters.answer import EngineAnswer
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.run_files import load_runs
from ghostball.validation.scenes.library import find_scene

RUN = {
    "engine": "elsewhere",
    "scene": "stop",
    "status": "rest",
    "rest_time": 1.0,
    "rest_positions": [[0.5, 0.5, 0.028575]],
    "events": [{"t": 0.5, "kind": "ball-cushion", "a": 0, "b": "left"}],
    "samples": {
        "t": [0.0, 1.0],
        "positions": [[[0.4, 0.5, 0.028575]], [[0.5, 0.5, 0.028575]]],
        "velocities": [[[0.2, 0.0, 0.0]], [[0.0, 0.0, 0.0]]],
        "angular_velocities": [[[0.0, 7.0, 0.0]], [[0.0, 0.0, 0.0]]],
    },
}


def test_a_run_of_another_shape_is_refused(tmp_path):
    ball = {"id": "b", "position": (0.4, 0.5)}
    table = {"length": 2.0, "width": 1.0}
    scene = Scene.model_validate({"name": "a", "balls": [ball], "table": table})

    def read(path):
        for one in load_runs(path):
            one.result(scene)

    assert reads(read, tmp_path / "run.json", json.dumps(RUN))
    large = (1 << 40, 10**400, 1e300)
    every = [*texts(json.dumps(RUN)), *map(json.dumps, faults(RUN, large)), "9" * 10_000]
    read_all = [text for text in every if reads(read, tmp_path / "run.json", text)]
    assert 0 < len(read_all) < len(every) / 2


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[" * 100_000, "it is nested too deeply"),
        ('{"scene": ' * 100_000, "it is nested too deeply"),
        (json.dumps(RUN | {"reason": "\ud800"}), "surrogates not allowed"),
        (json.dumps(RUN)[:-1], "Expecting ',' delimiter"),
    ],
)
def test_a_text_that_is_not_json_is_refused(tmp_path, text, why):
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(EngineError, match=f"isn't valid JSON: .*{why}"):
        load_runs(tmp_path / "run.json")


@pytest.mark.parametrize("layout", ["one", "list", "lines"])
def test_a_key_that_is_given_twice_is_refused(tmp_path, layout):
    # The last value once counted, so other readers of the same file saw a different run.
    text = json.dumps(RUN).replace('"t": 0.5', '"t": 0.5, "t": 0.25')
    text = {"one": text, "list": f"[{text}]", "lines": f"{json.dumps(RUN)}\n{text}\n"}[layout]
    (tmp_path / "run.json").write_text(text)
    with pytest.raises(EngineError, match=r"run\.json: `t` must be given once in an object"):
        load_runs(tmp_path / "run.json")


def test_a_byte_order_mark_is_no_part_of_a_run(tmp_path):
    (tmp_path / "run.json").write_text("\ufeff" + json.dumps(RUN), encoding="utf-8")
    assert load_runs(tmp_path / "run.json")[0].engine == "elsewhere"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"status": "done"}, "a file, run 1: `status` must be 'rest', .* got 'done'"),
        ({"rest_positions": [[0.0]]}, r"`rest_positions` must have the shape \(1, 3\) .* got"),
        ({"rest_positions": [["x", 0]]}, "`rest_positions` must be numbers: could not convert"),
        ({"rest_positions": [[10**400, 0]]}, "`rest_positions` must be numbers: int too large"),
        ({"events": [{"t": -1, "kind": "ball-ball", "a": 0}]}, r"`events\[0\].t` must be greater"),
        ({"events": [{"kind": "ball-ball", "a": 0}]}, r"`events\[0\].t` is missing, got kind, a"),
        ({"events": [{"t": 0.0, "kind": "bang", "a": 0}]}, r"`events\[0\].kind` must be one of"),
        ({"events": [{"t": 0.0, "kind": "ball-cushion", "a": 0, "b": "up"}]}, "left, right"),
        ({"samples": None}, "`samples` is missing"),
        (
            {"approximate": {"balls of different mass": "equal masses"}},
            "`approximate` must have as keys the names of features that `ghostball engines "
            "ghostball` lists, such as 'pure rolling', perhaps 'balls of different masses', got "
            "'balls of different mass'",
        ),
        ({"approximate": {"no cushions": "x"}}, "such as 'pure rolling', got 'no cushions'"),
        ({"samples": {"t": [0], "positions": [], "velocities": []}}, "must have the shape"),
    ],
)
def test_what_is_no_run_of_its_scene_is_refused_with_its_place(change: dict, says: str) -> None:
    """Answers of functions use the same model; their mistakes are tested in `test_answer`."""
    with pytest.raises(EngineError, match=says):
        EngineAnswer.parse(RUN | change, "a file, run 1").result(find_scene("stop"))


POSTED = {"length": 2.0, "width": 1.0, "posts": [{"centre": (1.5, 0.5), "radius": 0.1}]}
POLYGON = {"vertices": [(0.0, 0.0), (2.0, 0.0), (1.0, 1.5)]}
SHAPED = {"posts": POSTED, "polygon": POLYGON, "pocketed": {"preset": "wpa-8ft"}, "no table": None}


@pytest.mark.parametrize(
    ("table", "kind", "says"),
    [
        ("posts", "ball-cushion", "must be one of left, right, bottom, top, post-1 for"),
        ("polygon", "ball-cushion", "must be one of side-1, side-2, side-3 for"),
        ("pocketed", "pocketed", "must be one of bottom-left, bottom, bottom-right, top-right, "),
        ("pocketed", "leaves-table", "left, right, bottom, top, bottom-left-pocket, "),
        ("posts", "pocketed", "must be the name of an existing cushion or pocket for an event of"),
        ("no table", "ball-cushion", "must be the name of an existing cushion or pocket"),
        ("posts", "ball-ball", "must be the index of a ball for an event of kind ball-ball, got"),
        ("posts", "ball-cloth", "must be null for an event of kind ball-cloth, got 'post-2'"),
    ],
)
def test_a_partner_that_is_not_there_is_refused_with_those_that_are(
    table: str, kind: str, says: str
) -> None:
    ball = {"id": "b", "position": (1.0, 0.5)}
    scene = Scene.model_validate({"name": "a", "balls": [ball], "table": SHAPED[table]})
    event = {"t": 0.5, "kind": kind, "a": 0, "b": "post-2"}
    with pytest.raises(EngineError, match=says):
        EngineAnswer.parse(RUN | {"events": [event]}, "a file, run 1").result(scene)


def test_counts_are_those_that_the_run_states_else_those_of_its_events() -> None:
    scene, stated = find_scene("stop"), {"ball-ball": 2, "ball-cushion": 1}
    counted = EngineAnswer.parse(RUN, "a file, run 1").result(scene)
    assert counted.collision_counts == {"ball-ball": 0, "ball-cushion": 1}
    said = EngineAnswer.parse(RUN | {"collision_counts": stated}, "a file, run 1").result(scene)
    assert said.collision_counts == stated


def test_partners_are_named_as_events_of_ours_name_them() -> None:
    ball = {"id": "b", "position": (1.0, 0.5)}
    scene = Scene.model_validate({"name": "a", "balls": [ball], "table": POSTED})
    event = {"t": 0.5, "kind": "ball-cushion", "a": 0, "b": "post-1"}
    run = EngineAnswer.parse(RUN | {"events": [event]}, "a file, run 1").result(scene)
    assert run.events["b"].tolist() == [FIRST_POST]
