"""A baseline's file: readable, read back to the bit, refused where it was edited into nonsense."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from pathlib import Path

import gate
import numpy as np
import pytest

from ghostball.validation.baselines.bands import Band
from ghostball.validation.baselines.baseline import Baseline, BaselineSchemaError, load_baseline
from ghostball.validation.baselines.observed import KEPT_EVENTS
from ghostball.validation.baselines.places import BaselineError, baseline_names, baseline_path

RUN = gate.observed(gate.cut_shot())
BASELINE = Baseline.of(RUN, gate.ACCEPTED)
ADVICE = "Restore it (git checkout), or remove it and accept anew"


@pytest.fixture
def file(tmp_path):
    """A valid baseline."""
    path = baseline_path(tmp_path, "cut")
    path.write_text(BASELINE.text(), encoding="utf-8")
    return path


def same(one, other):
    for part in fields(one):
        before, after = getattr(one, part.name), getattr(other, part.name)
        if isinstance(before, np.ndarray):
            assert before.dtype == after.dtype, part.name
            assert before.tobytes() == after.tobytes(), part.name
        else:
            assert before == after, part.name
    return True


# --- round trip -------------------------------------------------------------------------------


def test_a_baseline_reads_back_to_the_bit(file):
    loaded = load_baseline(file)
    assert loaded == BASELINE
    assert loaded.text() == BASELINE.text()
    assert same(loaded.observed, RUN)


@pytest.mark.parametrize("count", [KEPT_EVENTS - 1, KEPT_EVENTS, KEPT_EVENTS + 1, 1000])
def test_a_long_log_is_kept_up_to_its_first_events_with_hashes_of_all(tmp_path, count):
    run = gate.with_events(RUN, gate.long_log(count))
    path = baseline_path(tmp_path, "cut")
    path.write_text(Baseline.of(run, gate.ACCEPTED).text(), encoding="utf-8")
    assert same(load_baseline(path).observed, gate.as_accepted(run))


OURS = Path(__file__).parents[3] / "benchmarks/baselines/ghostball"


@pytest.mark.parametrize("name", baseline_names(OURS))
def test_every_shipped_baseline_is_what_would_be_written(name):
    # Else the next acceptance would rewrite lines that nobody asked about.
    path = baseline_path(OURS, name)
    assert load_baseline(path).text() == path.read_text(encoding="utf-8")


# --- bands that were edited -------------------------------------------------------------------


def edited(name, **changes):
    value = BASELINE.metrics[name].model_copy(update=changes)
    return BASELINE.model_copy(update={"metrics": {**BASELINE.metrics, name: value}})


def test_a_band_that_was_edited_stays_while_it_holds_the_value():
    earlier = edited("rest_error_max", low=0.0, high=1e-6, level="warn", why="a loose scene")
    head = replace(RUN, metrics={**RUN.metrics, "rest_error_max": 1e-8})
    accepted = Baseline.of(head, gate.ACCEPTED, earlier)
    assert accepted.metrics["rest_error_max"].value == 1e-8
    assert accepted.bands.metrics["rest_error_max"] == Band(0.0, 1e-6, "warn", "a loose scene")
    line = 'rest_error_max = { value = 1e-08, low = 0.0, high = 1e-06, level = "warn", why = "a'
    assert line in accepted.text()


def test_a_number_that_may_not_move_is_one_and_a_band_is_three():
    lines = BASELINE.text().splitlines()
    assert "matching_events = 2" in lines
    (line,) = (one for one in lines if one.startswith("rest_error_max = "))
    assert line.startswith("rest_error_max = [1e-12, ")
    assert BASELINE.bands == gate.bands_of(RUN)


def test_a_value_outside_the_edited_band_gets_a_new_band_of_the_edited_level():
    earlier = edited("rest_error_max", level="warn", why="a loose scene")
    head = replace(RUN, metrics={**RUN.metrics, "rest_error_max": 1e-3})
    value = Baseline.of(head, gate.ACCEPTED, earlier).metrics["rest_error_max"]
    assert 1e-3 < value.high < 1e-2
    assert value.level == "warn"


# --- edited into nonsense ---------------------------------------------------------------------

HASH = RUN.bits
EDITS = {
    "value outside its band": (
        r"(rest_error_max = \[)1e-12",
        r"\g<1>1.0",
        ["`metrics.rest_error_max`", "`value` must lie between `low` and `high`", "got 1.0 for"],
    ),
    "nan": (
        r"(rest_error_max = \[)1e-12",
        r"\1nan",
        ["metrics.rest_error_max.value", "finite", "nan"],
    ),
    "infinite band": (
        r"(rest_error_max = \[1e-12, )[^,]+",
        r"\1-inf",
        ["metrics.rest_error_max.low` must be a finite", "-inf"],
    ),
    "band of two": (
        r"(rest_error_max = \[1e-12), [^,]+",
        r"\1",
        ["`metrics.rest_error_max` must be a number, [value, low, high] or a table, got [1e-12, "],
    ),
    "text for a number": (
        r"(rest_error_max = \[)1e-12",
        r'\1"1e-12"',
        ["metrics.rest_error_max.value` must be a valid number", "'1e-12'"],
    ),
    "true for a number": (
        r"(matching_events = )2",
        r"\1true",
        ["metrics.matching_events.value", "True"],
    ),
    "a count that is none": (
        r"(\[work\]\nevents = )\d+",
        r"\g<1>2.5",
        ["`work.events.value` must be an integer, got 2.5"],
    ),
    "unknown metric": (r"rest_error_max", "rest_error_mix", ["`rest_error_mix`"]),
    "unknown level": (
        r"rest_error_max = .*",
        r'rest_error_max = { value = 1e-12, level = "fatal" }',
        ["`metrics.rest_error_max.level`", "'off', 'warn' or 'error'", "got 'fatal'"],
    ),
    "unknown field": (
        r"\[accepted\]",
        "[accepted]\nwho = 3",
        ["`accepted.who` is not a known field"],
    ),
    "field missing": (r"revision = .*\n", "", ["`accepted.revision` is missing"]),
    "reason blank": (r'reason = ".*"', 'reason = " "', ["`accepted.reason`", "got ' '"]),
    "hash changed": (HASH, "0" * 64, ["`hash` isn't that of the events and rest positions"]),
    "hash shortened": (HASH, HASH[:-1], ["`hash.bits`", "must match pattern"]),
    "sequence changed": (RUN.sequence, "1" * 64, ["`hash` isn't that of the events"]),
    "ball moved": (
        re.escape(repr(float(RUN.rest_positions[0, 0]))),
        "1.0",
        ["`hash` isn't that of the"],
    ),
    "ball of two coordinates": (
        r"(object = \[[^,]+, [^,]+), [^,]+\]",
        r"\1]",
        ["`end.balls.object[2]` is missing"],
    ),
    "ball twice": (r"object = ", "cue = ", ["not valid TOML"]),
    "event later": (
        re.escape(repr(float(RUN.events["t"][0]))),
        "0.5",
        ["`hash` isn't that of the events"],
    ),
    "event of other balls": (
        r"ball-ball 0 1",
        "ball-ball 1 0",
        ["`hash` isn't that of the events"],
    ),
    "event of an unknown kind": (
        r"ball-ball 0 1",
        "ball-bell 0 1",
        ["`events.first[0]` must be an event such as", "ball-bell"],
    ),
    "event of an impossible ball": (
        r"ball-ball 0 1",
        "ball-ball 99999999999 1",
        ["`events.first[0]` must be", "99999999999"],
    ),
    "event of one ball": (r"ball-ball 0 1", "ball-ball 0", ["`events.first[0]` must be"]),
    "event of a cushion that is none": (
        r"ball-cushion (\d) \w+",
        r"ball-cushion \1 roof",
        ["`events.first[", "roof"],
    ),
    "event removed": (
        r'    ".*ball-ball 0 1",\n',
        "",
        ["`events.first` must hold the first"],
    ),
    "count changed": (
        r"\ncount = \d+",
        "\ncount = 3",
        ["must hold the first 3 of 3"],
    ),
    "no count": (r"\ncount = \d+", "\ncount = -1", ["`events.count`", "got -1"]),
    "another scene": (r'scene = "cut"', 'scene = "break-7"', ["name of its file", '"break-7"']),
    "no schema": (r"schema = 3\n", "", ["holds no `schema`"]),
    "no engine": (r'engine = "ghostball"\n', "", ["`engine`"]),
    "twice": (r"\[accepted\]", "[accepted]\n[accepted]", ["not valid TOML"]),
}


@pytest.mark.parametrize("kind", EDITS)
def test_nonsense_is_refused_by_its_name(file, kind):
    pattern, replacement, parts = EDITS[kind]
    text, count = re.subn(pattern, replacement, file.read_text(encoding="utf-8"), count=1)
    assert count == 1, "nothing was edited"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(BaselineError) as raised:
        load_baseline(file)
    message = str(raised.value)
    assert message.startswith(f"{file}:")
    assert message.endswith(ADVICE)
    assert not isinstance(raised.value, BaselineSchemaError)
    assert message.count("\n") == 0
    for part in parts:
        assert part in message


@pytest.mark.parametrize("part", [0.0, 0.3, 0.6, 0.9, 0.995])
def test_a_file_that_was_cut_short_is_refused(file, part):
    # A full disk, a copy that broke off: none of it may count as another version, or as nothing.
    content = file.read_bytes()
    file.write_bytes(content[: int(part * len(content))])
    with pytest.raises(BaselineError, match=re.escape(str(file))) as raised:
        load_baseline(file)
    assert not isinstance(raised.value, BaselineSchemaError)


@pytest.mark.parametrize("schema", ["2", "4", "0", '"3"', "[]"])
def test_another_schema_is_an_error_of_its_own(file, schema):
    before = file.read_text(encoding="utf-8")
    text = before.replace("schema = 3", f"schema = {schema}")
    assert text != before, "nothing was edited"
    file.write_text(text + "\nnews = 1\n", encoding="utf-8")
    with pytest.raises(BaselineSchemaError, match=r":1: `schema` must be 3, got .*accept anew"):
        load_baseline(file)


def test_a_baseline_of_another_engine_is_refused_at_its_line(file):
    with pytest.raises(BaselineError, match=r":2: `engine` must be `mine`, got"):
        load_baseline(file, "mine")
