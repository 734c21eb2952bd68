"""Golden shots: the files of the folder, and the answers that pass the comparison.

`faults_of` is a reader written from the README of a folder alone; it shares no code with Ghostball.
"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import wrong_physics as physics
import wrong_runs as runs
from commands import cli, refused
from same.images import shuffled

from ghostball.engine import simulate
from ghostball.model import EventKind, GhostballError, Result, Scene
from ghostball.model.result import event_dict
from ghostball.model.scene import json_schema
from ghostball.validation.golden.format import SCHEMA_FILES, golden_schema, read_golden
from ghostball.validation.golden.shots import FAMILIES, golden_files, golden_shot
from ghostball.validation.scenes.library import FOLDER, find_scene
from ghostball.validation.scenes.random_scenes import random_scene

EXAMPLES = Path(__file__).parents[3] / "validation" / "examples"

Shots = Mapping[str, dict[str, Any]]

SHIPPED = (
    *("half-ball-cut", "wall-bounce", "three-ball-chain", "draw-shot", "stop", "chaos-a"),
    *("side-30", "cradle", "air-curves", "flight-lands"),
)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a small folder of golden shots: some shipped scenes, and a random one per family."""
    folder = tmp_path_factory.mktemp("golden")
    scenes = [find_scene(name) for name in SHIPPED]
    numbers = {"cut": 3, "bank": 3, "spin": 1, "break": 2, "pocket": 7, "stroke": 0, "flight": 4}
    for name, number in numbers.items():
        scene = random_scene(number, **FAMILIES[name].having)
        scenes.append(scene.model_copy(update={"name": f"{name}-{number}"}))
    for scene in scenes:
        shot = golden_shot(Scene.model_validate(scene.model_dump(by_alias=True)))
        assert shot is not None, scene.name
        (folder / f"{scene.name}.json").write_text(json.dumps(shot.to_values(), indent=1))
    return folder


@pytest.fixture(scope="session")
def shots(folder: Path) -> Shots:
    return {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))}


# --- a reader that knows only the README


def faults_of(shot: dict[str, Any], answer: dict[str, Any], factor: float = 1.0) -> list[str]:
    def key(event: dict[str, Any]) -> tuple[Any, ...]:
        bodies = (event["a"], event["b"])
        return (event["kind"], *(sorted(bodies) if event["kind"] == "ball-ball" else bodies))

    numbers = [event["t"] for event in answer["events"]]
    numbers += [x for place in answer["rest_positions"] or [] for x in place]
    if not all(map(math.isfinite, numbers)):
        return ["not finite"]
    for one in answer["events"]:
        named = [one["a"], one["b"]] if one["kind"] == "ball-ball" else [one["a"]]
        if len({*named} & {*range(len(shot["scene"]["balls"]))}) < len(named):
            return ["index"]
    faults, left = [], list(answer["events"])
    kinds = {"ball-ball", "ball-cushion", "pocketed"} | {event["kind"] for event in left}
    pairs = list(zip(shot["events"], shot["tolerance"]["events"], strict=True))
    for event, tolerance in pairs:
        if event["kind"] not in kinds:
            continue
        same = [one for one in left if key(one) == key(event)]
        if not same:
            faults.append("missing event")
            continue
        found = min(same, key=lambda one: abs(one["t"] - event["t"]))
        if not abs(found["t"] - event["t"]) <= factor * tolerance:
            faults.append("time of event")
        left.remove(found)
    for extra in left:
        until = shot["valid_until"]
        if until is not None and extra["t"] >= until - factor * pairs[-1][1]:
            continue
        own = [
            abs(event["t"] - extra["t"]) <= factor * tolerance
            for event, tolerance in pairs
            if extra["a"] == event["a"]
            or (event["kind"] == "ball-ball" and extra["a"] == event["b"])
        ]
        if extra["kind"] in ("slide-to-roll", "roll-to-rest", "ball-cloth") and any(own):
            continue
        faults.append("extra event")
    if shot["rest_positions"] is not None:
        for place, found, tolerance in zip(
            shot["rest_positions"],
            answer["rest_positions"],
            shot["tolerance"]["rest_positions"],
            strict=True,
        ):
            if not all(abs(x - y) <= factor * tolerance for x, y in zip(place, found, strict=True)):
                faults.append("rest position")
    return faults


# --- engines


def answer(result: Result) -> dict[str, Any]:
    assert result.events is not None
    return {
        "events": [event_dict(event) for event in result.events],
        "rest_positions": result.rest_positions.tolist(),
    }


def ours(scene: Scene) -> Result:
    return simulate(scene, record="events")


def renumbered(scene: Scene) -> Result:
    """Simulate with the balls in reverse order."""
    n = len(scene.balls)
    result = simulate(shuffled(scene, range(n)[::-1]), record="events")
    assert result.events is not None
    events = result.events.copy()
    events["a"] = n - 1 - events["a"]
    of_balls = events["kind"] == EventKind.BALL_BALL
    events["b"][of_balls] = n - 1 - events["b"][of_balls]
    end = type(result.final_state)(*(state[:, ::-1] for state in result.final_state))
    return replace(result, events=events, final_state=end)


def collisions_alone(scene: Scene) -> Result:
    """Report only events of the required kinds, with each number rounded once more."""
    result = runs.rounded_once(scene)
    events = runs.events_in(result)
    wanted = [EventKind.BALL_BALL, EventKind.BALL_CUSHION, EventKind.POCKETED]
    return replace(result, events=events[np.isin(events["kind"], wanted)])


Play = Callable[[Scene], Result]

RIGHT: dict[str, Play] = {
    "ours": ours,
    "renumbered": renumbered,
    "collisions alone": collisions_alone,
}

WRONG: dict[str, Play] = {
    "late by 1 ns": runs.late(1e-9),
    "milliseconds": runs.in_milliseconds,
    "first collision missing": runs.without_first_collision,
    "first collision twice": runs.first_collision_twice,
    "another cushion": runs.with_another_cushion,
    "another ball": runs.with_another_ball,
    "1 nm off": runs.ends_moved(runs.along_x(1e-9)),
    "swapped ends": runs.ends_moved(runs.swapped),
    "single precision": runs.in_single_precision,
    "rolling friction": physics.with_physics(rolling_friction=lambda mu: mu * (1.0 + 1e-9)),
    "gravity": physics.with_physics(gravity=lambda g: g * (1.0 + 1e-9)),
    "restitution": physics.with_physics(ball_restitution=lambda e: e * (1.0 - 1e-9)),
    "mass": physics.with_balls(mass=lambda m: m * (1.0 + 1e-9)),
}


def answers_of(play: Play, shots: Shots) -> dict[str, dict[str, Any]]:
    """Return the answers of an engine; shots in which its fault can't be planted are left out."""
    answers = {}
    for name, shot in shots.items():
        try:
            answers[name] = answer(play(Scene.model_validate(shot["scene"])))
        except (IndexError, AssertionError):
            assert play in WRONG.values()
    return answers


@pytest.fixture
def grade(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., tuple[int, str]]:
    monkeypatch.setenv("COLUMNS", "200")  # a row on one line

    def run(answers: Any, *options: str) -> tuple[int, str]:
        (tmp_path / "answers.json").write_text(json.dumps(answers))
        done = cli("grade", "--golden", folder, tmp_path / "answers.json", *options)
        return done.exit_code, done.output

    return run


@pytest.mark.parametrize("name", RIGHT)
def test_right_engines_pass(shots, grade, name):
    answers = answers_of(RIGHT[name], shots)
    assert len(answers) == len(shots)
    assert [shot for shot in answers if faults_of(shots[shot], answers[shot])] == []
    status, shown = grade(answers)
    assert status == 0, shown


@pytest.mark.parametrize("name", WRONG)
def test_wrong_engines_are_caught(shots, grade, name):
    answers = answers_of(WRONG[name], shots)
    caught = {shot for shot in answers if faults_of(shots[shot], answers[shot])}
    assert caught
    status, shown = grade(answers)
    assert status == 1
    assert {shot for shot in answers if f"{shot} on " in shown} == caught


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", ["stop", "chaos-a"])
def test_a_number_that_is_not_finite_fails(shots, grade, number, name):
    """A number that isn't finite fails, even where the golden shot has no number to compare."""
    given = answers_of(ours, {name: shots[name]})
    given[name]["rest_positions"][0][1] = number
    assert faults_of(shots[name], given[name]) == ["not finite"]
    status, shown = grade(given)
    assert status == 1
    assert f"`rest_positions[0][1]` must be a finite number, got {number}" in shown
    given = answers_of(ours, {name: shots[name]})
    last = len(given[name]["events"]) - 1
    given[name]["events"][-1]["t"] = number
    status, shown = grade(given)
    assert status == 1
    assert f"`events[{last}].t` must be a finite number, got {number}" in shown


def test_single_precision_passes_with_its_factor(shots, grade):
    given = answers_of(runs.in_single_precision, shots)
    assert not any(faults_of(shots[name], one, factor=2.0**29) for name, one in given.items())
    assert grade(given, "--factor", str(2**29))[0] == 0
    needed = float(grade(given)[1].split("answers.json")[1].split()[5])  # "in tolerances"
    assert 1.0 < needed < 2.0**29
    assert grade(given, "--factor", str(1.01 * needed))[0] == 0
    assert grade(given, "--factor", str(0.99 * needed))[0] == 1


@pytest.mark.parametrize("factor", ["0", "-1", "nan", "inf"])
def test_a_factor_must_be_positive_and_needs_golden_shots(grade, factor, tmp_path):
    status, shown = grade({}, "--factor", factor)
    assert status == 2
    assert "`--factor` must be finite and greater than 0" in shown
    assert refused(cli("grade", tmp_path / "answers.json", "--factor", "2"), "needs `--golden`")


def test_a_folder_of_golden_shots_passes_as_its_own_answers(folder):
    done = cli("grade", "--golden", folder, folder)
    assert done.exit_code == 0, done.output
    assert "not the name of a golden shot" not in done.output


def test_rest_positions_may_be_missing_where_the_shot_has_none(shots, grade):
    given = answers_of(ours, {name: shots[name] for name in ("chaos-a", "break-2")})
    given["chaos-a"]["rest_positions"] = None
    del given["break-2"]["rest_positions"]
    status, shown = grade(given)
    assert status == 0, shown


def test_unknown_names_are_said_and_the_rest_is_graded(shots, grade, folder, tmp_path):
    given = answers_of(ours, {"stop": shots["stop"]})
    status, shown = grade(given | {"craddle": {}})
    assert status == 0, shown
    words = "not the name of a golden shot: craddle. The nearest name to the first is cradle"
    assert words in shown.replace("\n", " ")
    assert "no answer in" in shown
    assert "and 11 more" in shown
    (tmp_path / "answers").mkdir()
    for name in ("stop", "craddle"):
        (tmp_path / "answers" / f"{name}.json").write_text(json.dumps(given["stop"]))
    done = cli("grade", "--golden", folder, tmp_path / "answers")
    assert done.exit_code == 0, done.output
    assert words in done.output.replace("\n", " ")


def test_mistaken_arguments_are_explained(shots, folder, tmp_path):
    given = answers_of(ours, {"stop": shots["stop"]})
    for name, one in (("one", given["stop"]), ("shot", shots["stop"]), ("all", given)):
        (tmp_path / f"{name}.json").write_text(json.dumps(one))
    for name in ("one", "shot"):
        done = cli("grade", "--golden", folder, tmp_path / f"{name}.json")
        assert refused(done, "a single answer belongs in NAME.json in a folder, or under its name")
    for path in (folder, tmp_path / "all.json"):
        done = cli("grade", path)
        assert done.exit_code == 1
        assert "For golden shots use `--golden DIR`" in done.output.replace("\n", " ")


def test_answers_may_be_files_in_a_folder(folder, shots, tmp_path):
    for name, one in answers_of(ours, shots).items():
        (tmp_path / f"{name}.json").write_text(json.dumps(one))
    (tmp_path / "stop.json").write_text("[]")
    done = cli("grade", "--golden", folder, tmp_path)
    assert done.exit_code == 1
    assert "stop.json must hold one object, got list" in done.output.replace("\n", "")


BAD = [
    ({"no-such": {}}, 4, "not the name of a golden shot: no-such"),
    ({"stop": {"events": []}}, 1, "`rest_positions` is missing"),
    (
        {"stop": {"events": [], "rest_positions": [[1.0]]}},
        1,
        "`rest_positions` must have the shape",
    ),
    (
        {"stop": {"events": [], "rest_positions": None}},
        1,
        "`rest_positions` must be numbers, got null",
    ),
    (
        {"stop": None},
        1,
        "the answer must be an object with `events` and `rest_positions`, got null",
    ),
    ({"stop": [1]}, 1, "must be an object with `events` and `rest_positions`, got [1]"),
    ({}, 4, "answers none of the golden shots"),
]


@pytest.mark.parametrize(("answers", "status", "words"), BAD, ids=range(len(BAD)))
def test_invalid_answers(grade, answers, status, words):
    found, shown = grade(answers)
    assert found == status, shown
    assert words in shown.replace("\n", " ")


BAD_EVENTS = [
    (
        "slide-to-roll",
        1,
        None,
        "a` must be the index of a ball, 0 to 0, got 1 (indices start at 0)",
    ),
    ("ball-cushion", 9, "left", "a` must be the index of a ball, 0 to 0, got 9"),
    ("ball-ball", 0, 99, "b` must be the index of a ball, 0 to 0, got 99"),
    ("ball-ball", 0, None, "b` must be the index of a ball, 0 to 0, got null"),
    ("ball-ball", 0, -1, "b` must be the index of a ball, 0 to 0, got -1"),
    ("ball-ball", 0, 0, "b` must be another ball than `a`, got 0 for both"),
    (
        "ball-cushion",
        0,
        99,
        "b` must be left, right, bottom, top for the kind ball-cushion, got 99",
    ),
    ("ball-cushion", 0, None, "b` must be left, right, bottom, top for the kind ball-cushion, got"),
    ("pocketed", 0, None, "b` must be an obstacle of this scene, which has none,"),
    ("roll-to-rest", 0, 0, "b` must be null for the kind roll-to-rest, got 0"),
]


@pytest.mark.parametrize(("kind", "a", "b", "words"), BAD_EVENTS)
def test_events_must_name_bodies_of_the_scene(shots, grade, kind, a, b, words):
    assert len(shots["stop"]["scene"]["balls"]) == 1
    event = {"t": 0.5, "kind": kind, "a": a, "b": b}
    given = {"events": [event], "rest_positions": shots["stop"]["rest_positions"]}
    status, shown = grade({"stop": given})
    assert status == 1
    assert f"`events[0].{words}" in shown.replace("\n", " ")


def test_damaged_golden_shots_are_refused(folder, tmp_path):
    (tmp_path / "answers.json").write_text("{}")
    command = ("grade", tmp_path / "answers.json", "--golden", tmp_path / "golden")
    assert refused(cli(*command), "holds no golden shots")
    shot = json.loads((folder / "stop.json").read_text())
    (tmp_path / "golden").mkdir()
    for change, words in (
        ({"schema": 2}, "`schema` must be 1"),
        ({"tolerance": {"events": [], "rest_positions": None}}, "`tolerance.events` must have"),
        ({"scene": {}}, "stop.json isn't a golden shot"),
    ):
        (tmp_path / "golden" / "stop.json").write_text(json.dumps(shot | change))
        assert refused(cli(*command), words)


# --- the folder


def test_every_default_of_a_scene_is_written_out(shots, folder):
    read = read_golden(folder)
    for name, shot in shots.items():
        scene = Scene.model_validate(shot["scene"])
        assert read[name].scene == scene
        assert read[name].to_values() == shot
        assert shot["scene"]["physics"].keys() == type(scene.physics).model_fields.keys()
        assert all("strike" not in ball for ball in shot["scene"]["balls"])
        assert (name == "stroke-0") == (len(shot["strikes"]) > 0)


def test_only_a_proof_of_a_part_has_an_end(shots):
    ended = {name for name, shot in shots.items() if shot["valid_until"] is not None}
    assert ended == {name for name, shot in shots.items() if shot["rest_positions"] is None}
    assert ended == {"chaos-a", "break-2"}
    assert shots["air-curves"]["reference"] == "integration"
    assert shots["half-ball-cut"]["reference"] == "closed form"


def test_a_scene_without_a_reference_has_no_golden_shot():
    assert golden_shot(find_scene("mathavan-cut")) is None


def test_the_schema_beside_the_scenes_is_current():
    # To renew the file: python -c "from ghostball.validation.golden.format import *;
    # print(golden_schema())" > validation/scenes/golden.schema.json
    assert (FOLDER / SCHEMA_FILES[0]).read_text(encoding="utf-8") == golden_schema() + "\n"


def test_golden_shots_follow_their_schema(shots):
    jsonschema, referencing = map(pytest.importorskip, ("jsonschema", "referencing"))
    texts = dict(zip(SCHEMA_FILES, (golden_schema(), json_schema()), strict=True))
    schemas = {name: json.loads(text) for name, text in texts.items()}
    known = referencing.Registry().with_resources(
        (name, referencing.Resource.from_contents(schema)) for name, schema in schemas.items()
    )
    validator = jsonschema.Draft7Validator(schemas[SCHEMA_FILES[0]], registry=known)
    for shot in shots.values():
        validator.validate(shot)
        assert not validator.is_valid(shot | {"scene": shot["scene"] | {"balls": "none"}})
        assert not validator.is_valid(shot | {"events": [{"t": 0.0}]})


def test_a_folder_that_is_not_empty_is_refused(tmp_path):
    (tmp_path / "mine").write_text("")
    assert refused(cli("scenes", "--golden", tmp_path), "must name a new or empty folder")
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]
    assert refused(cli("scenes", "stop", "--golden", tmp_path / "new"), "writes all golden shots")


@pytest.mark.slow
def test_the_whole_folder(tmp_path):
    """Golden shots are reproducible, cover each family, and our engine passes all of them."""
    files = golden_files()
    assert files == golden_files()
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    read = read_golden(tmp_path)
    assert 180 <= len(read) <= 260
    assert all(sum(name.startswith(f"{family}-") for name in read) >= 12 for family in FAMILIES)
    assert {shot.reference for shot in read.values()} == {"closed form", "proof", "integration"}
    shots = {name: json.loads(files[f"{name}.json"]) for name in read}
    given = answers_of(ours, shots)
    assert len(given) == len(shots)
    assert [name for name in given if faults_of(shots[name], given[name])] == []


# --- examples in other languages


def verdicts(command: list[str], cwd: Path) -> tuple[int, str]:
    done = subprocess.run(command, cwd=cwd, check=False, capture_output=True, text=True)
    assert done.stderr == ""
    return done.returncode, done.stdout


LATE_EVENTS = (
    {"kind": "ball-ball", "a": 1, "b": 0},
    {"kind": "ball-cushion", "a": 0, "b": "left"},
    {"kind": "ball-ball", "a": 0, "b": 99},
    {"kind": "ball-ball", "a": 0, "b": 0},
    {"kind": "ball-ball", "a": 0, "b": None},
    {"kind": "ball-ball", "a": -1, "b": 0},
    {"kind": "ball-cushion", "a": 99, "b": "left"},
)
"""Events that can't be compared; only the first two name balls of the scene."""


@pytest.mark.checkout
@pytest.mark.parametrize("language", ["cpp", "mjs"])
def test_the_examples_say_the_same(shots, folder, tmp_path, language):
    if shutil.which({"cpp": "c++", "mjs": "node"}[language]) is None:
        pytest.skip(f"there is no compiler or interpreter for golden.{language}")
    source, program = str(EXAMPLES / f"golden.{language}"), str(tmp_path / "golden")
    if language == "cpp":
        subprocess.run(["c++", "-std=c++17", "-O1", source, "-o", program], check=True)
    chosen = [ours, collisions_alone, *list(WRONG.values())[:8]]
    for play in chosen:
        answers = answers_of(play, shots)
        caught = {name for name, one in answers.items() if faults_of(shots[name], one)}
        given = tmp_path / "answer.json"
        if language == "mjs":
            given.write_text(json.dumps(answers))
            command = ["node", source, str(folder), str(given)]
            status, shown = verdicts(command, tmp_path)
            assert status == (shown != "")
            assert {line.partition(": ")[0] for line in shown.splitlines()} == caught
            continue
        said = set()
        for name, one in answers.items():
            given.write_text(json.dumps(one))
            command = [program, str(folder / f"{name}.json"), str(given)]
            status, shown = verdicts(command, tmp_path)
            assert status == (shown != "")
            said |= {name} if status else set()
        assert said == caught
    # Events after the end of the comparison, which may be of any kind and time.
    extra = [{"t": shots["chaos-a"]["valid_until"] + 1.0, **one} for one in LATE_EVENTS]
    right = answers_of(ours, {"chaos-a": shots["chaos-a"]})["chaos-a"]
    for event in right["events"]:  # 1.0 is an index as 1 is
        event |= {key: float(event[key]) for key in ("a", "b") if isinstance(event[key], int)}
    wrong = right | {"rest_positions": [["infinite"] * 3, *right["rest_positions"][1:]]}
    for k, one in enumerate((*(right | {"events": [*right["events"], e]} for e in extra), wrong)):
        text = json.dumps(one if language == "cpp" else {"chaos-a": one})
        given.write_text(text.replace('"infinite"', "1e999"))
        if language == "cpp":
            command[1:] = [str(folder / "chaos-a.json"), str(given)]
        status, shown = verdicts(command, tmp_path)
        assert status == (k >= 2), (one["events"][-1], shown)


def test_read_golden_needs_a_folder(tmp_path):
    with pytest.raises(GhostballError, match="holds no golden shots"):
        read_golden(tmp_path / "none")
