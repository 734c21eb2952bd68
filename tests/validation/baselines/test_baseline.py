"""The file of a baseline holds a whole record, reads back to the bit, and is refused if edited."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

import gate
import numpy as np
import pytest

from ghostball.validation.baselines.baseline import (
    KEPT_EVENTS,
    Baseline,
    BaselineError,
    BaselineSchemaError,
    baseline_names,
    baseline_path,
    engine_folder,
    engine_key,
    load_baseline,
)
from ghostball.validation.results.records import Check
from ghostball.validation.suite.unchanged import hash_of

RUN = gate.played(gate.cut_shot())
BASELINE = Baseline.of(RUN, gate.ACCEPTED)
ADVICE = "Restore it (git checkout), or remove it and accept again"


@pytest.fixture
def file(tmp_path):
    """A valid baseline."""
    path = baseline_path(tmp_path, "cut")
    path.write_text(BASELINE.text, encoding="utf-8")
    return path


def same(one, other):
    for part in fields(one):
        before, after = getattr(one, part.name), getattr(other, part.name)
        if isinstance(before, np.ndarray):
            assert before.tobytes() == after.tobytes(), part.name
        else:
            assert before == after, part.name
    return True


def test_a_baseline_reads_back_to_the_bit(file):
    loaded = load_baseline(file)
    assert loaded.text == BASELINE.text
    assert loaded.accepted == gate.ACCEPTED
    assert same(loaded.played.record, RUN.record)
    assert same(loaded.played.log(), RUN.log())


@pytest.mark.parametrize("count", [0, KEPT_EVENTS - 1, KEPT_EVENTS, KEPT_EVENTS + 1, 1000])
def test_a_long_log_is_kept_up_to_its_first_events_with_hashes_of_all(tmp_path, count):
    run = gate.with_events(RUN, gate.long_log(count))
    path = baseline_path(tmp_path, "cut")
    path.write_text(Baseline.of(run, gate.ACCEPTED).text, encoding="utf-8")
    assert same(load_baseline(path).played.log(), gate.as_accepted(run).log())


def test_what_explains_or_judges_a_run_is_not_kept_and_each_number_has_a_line():
    check = Check("rest_error_max", 1.0, "at_most", 2.0, "m", passed=True, reason="long")
    metrics = {"wall_time": 3.0, "rest_error_max": 0.5, "overlap_max": None}
    run = gate.having(
        RUN, checks=(check,), notes={"a": "b"}, wall_time=3.0, measured="now", metrics=metrics
    )
    record = Baseline.of(run, gate.ACCEPTED).record
    assert record.metrics == {"rest_error_max": 0.5}
    assert (record.checks, record.notes, record.wall_time, record.measured) == ((), {}, None, "")
    lines = BASELINE.text.splitlines()
    assert f'"bits": "{RUN.record.bits}",' in lines
    assert '"rest_error_max": 1e-12,' in lines
    assert sum("ball-ball" in line for line in lines) == 1


OURS = Path(__file__).parents[3] / "benchmarks/baselines/ghostball"


@pytest.mark.parametrize("name", baseline_names(OURS))
def test_every_shipped_baseline_is_what_would_be_written(name):
    # Otherwise the next acceptance would change unrelated lines.
    path = baseline_path(OURS, name)
    assert load_baseline(path).text == path.read_text(encoding="utf-8")


# --- edited -----------------------------------------------------------------------------------


def edited(file, change, *, hashed):
    """Edit a file; `hashed`: whether to update its hash, too."""
    data = json.loads(file.read_text(encoding="utf-8"))
    change(data)
    if hashed:
        data["hash"] = hash_of([data.get("record"), data.get("events")])
    file.write_text(json.dumps(data), encoding="utf-8")


EDITS = {
    "metric": lambda data: data["record"]["metrics"].update(rest_error_max=1.0),
    "ball": lambda data: data["record"]["rest_positions"][0].__setitem__(0, 9.0),
    "scene": lambda data: data["record"]["definition"]["balls"][0].update(mass=1.0),
    "event": lambda data: data["events"]["first"][0].__setitem__(0, 0.5),
    "count": lambda data: data["record"]["work"].update(events=1),
    "bits": lambda data: data["record"].update(bits="0" * 64),
    "no run": lambda data: data["record"].update(outcome="failed"),
    "fewer events": lambda data: data["events"]["first"].pop(),
}


@pytest.mark.parametrize("kind", EDITS)
def test_an_edited_record_is_refused_by_its_hash(file, kind):
    edited(file, EDITS[kind], hashed=False)
    with pytest.raises(BaselineError, match=r"json: `(hash` doesn't match|record\.bits` isn't th)"):
        load_baseline(file)


NONSENSE = {
    "not finite": (lambda d: d["events"]["first"][0].__setitem__(0, math_inf), "events.first[0]"),
    "kind": (lambda d: d["events"]["first"][0].__setitem__(1, "hug"), "must be a kind of event"),
    "ball": (lambda d: d["events"]["first"][0].__setitem__(3, 7), "ball 7, but the scene has 2"),
    "bits": (lambda d: d["record"].update(bits="0" * 64), "`record.bits` isn't the hash of"),
    "far ball": (lambda d: d["events"]["first"][0].__setitem__(2, 2**40), "events.first[0]"),
    "shape": (lambda d: d["record"].update(rest_positions=[[1.0]]), "must have the shape (2, 3)"),
    "missing": (lambda d: d["record"].pop("scene"), "`record.scene` is missing"),
    "unknown": (lambda d: d["accepted"].update(who=3), "`accepted.who` is not a known field"),
    "reason": (lambda d: d["accepted"].update(reason=" "), "`accepted.reason`"),
    "count": (lambda d: d["events"].update(count=-1), "`events.count`"),
    "name": (lambda d: d["record"].update(scene="other"), "must be the name of its file"),
    "engine": (lambda d: d.update(engine="mine"), "`engine` must be `ghostball`, got `mine`"),
}
math_inf = float("inf")


@pytest.mark.parametrize("kind", NONSENSE)
def test_nonsense_is_refused_by_its_name_though_its_hash_is_right(file, kind):
    change, said = NONSENSE[kind]
    edited(file, change, hashed=True)
    with pytest.raises(BaselineError) as raised:
        load_baseline(file)
    message = str(raised.value)
    assert message.startswith(f"{file}: ")
    assert said in message
    assert "accept again" in message
    assert not isinstance(raised.value, BaselineSchemaError)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.6, 0.9, 0.995])
def test_a_file_that_was_cut_short_is_refused(file, part):
    # After a full disk or an interrupted copy, the rest of a file must not count as another
    # version, or as no baseline.
    content = file.read_bytes()
    file.write_bytes(content[: int(part * len(content))])
    with pytest.raises(BaselineError, match=re.escape(f"{file}: not valid JSON")) as raised:
        load_baseline(file)
    assert str(raised.value).endswith(ADVICE)


@pytest.mark.parametrize("schema", [2, 5, "4", [], None])
def test_another_schema_is_an_error_of_its_own(file, schema):
    edited(file, lambda data: data.update(schema=schema, news=1), hashed=False)
    with pytest.raises(BaselineSchemaError, match=r"`schema` must be 4, got .*accept again"):
        load_baseline(file)


# --- folders ----------------------------------------------------------------------------------


def test_an_engine_is_called_by_its_own_name_and_the_settings_that_it_was_given():
    where = "ghostball.validation.examples.stepper:Stepper:dt=1e-3"
    assert engine_key(where) == "stepper:dt=1e-3"
    assert engine_key("pymunk") == "pymunk"


def test_folders_of_engines_differ_and_stay_within(tmp_path):
    names = ("pymunk", "pymunk:dt=1e-3", "pymunk:dt=1e-4", "../else")
    folders = [engine_folder(tmp_path, name) for name in names]
    assert len({*folders}) == len(names)
    assert all(one.resolve().parent == tmp_path for one in folders)
    folders[0].touch()
    with pytest.raises(BaselineError, match=r"not a folder\. Choose another `--baselines`"):
        engine_folder(tmp_path, "pymunk")


def test_scenes_are_found_by_their_files(tmp_path):
    assert baseline_names(tmp_path / "none") == ()
    for name in ("b", "a"):
        baseline_path(tmp_path, name).touch()
    (tmp_path / "CHANGES.md").touch()
    assert baseline_names(tmp_path) == ("a", "b")
