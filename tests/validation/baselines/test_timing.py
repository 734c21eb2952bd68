"""Run times: intervals by order statistics, slower only beyond doubt, and what a machine keeps."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import gate
import pytest
from hypothesis import given, strategies as st

from engine import simulate
from validation.baselines import timing
from validation.baselines.regression import Timing
from validation.baselines.timing import (
    MachineTimes,
    SceneTimes,
    TimesError,
    compare_samples,
    compare_times,
    load_times,
    median_interval,
    save_times,
    time_scenes,
    times_path,
    timing_of,
)
from validation.bench.measurements import measured_where


@pytest.mark.parametrize(
    ("count", "confidence", "ranks"),
    # Conover 1999, table A3 of the binomial distribution: the largest rank r with
    # 2 P(X < r) <= 1 - confidence, for X of n tosses of a coin.
    [
        (5, 0.95, None),
        (6, 0.95, (1, 6)),
        (8, 0.95, (1, 8)),
        (9, 0.95, (2, 8)),
        (15, 0.95, (4, 12)),
        (20, 0.95, (6, 15)),
        (10, 0.999, None),
        (11, 0.999, (1, 11)),
        (15, 0.999, (2, 14)),
        (1, 0.95, None),
        (0, 0.95, None),
    ],
)
def test_the_interval_of_a_median_is_that_of_the_tables(count, confidence, ranks):
    values = [float(k + 1) for k in range(count)]
    expected = (-math.inf, math.inf) if ranks is None else ranks
    assert median_interval(values, confidence) == expected
    assert median_interval(values[::-1], confidence) == expected


def test_few_samples_have_their_range_as_interval():
    assert timing_of([3.0, 1.0, 2.0]) == Timing(median=2.0, low=1.0, high=3.0, samples=3)


# --- by turns ---------------------------------------------------------------------------------


def test_what_is_slower_in_every_round_is_slower():
    change = compare_samples([1.0] * 15, [1.2] * 15, 1.1)
    assert change.slower
    assert change.ratio == pytest.approx(1.2)
    assert change.ratio_low == pytest.approx(1.2)
    assert change.words == "1.20 times as slow, 1.20 at least"


@pytest.mark.parametrize("few", [1, 5, 10])
def test_few_rounds_leave_doubt_however_slow(few):
    change = compare_samples([1.0] * few, [9.0] * few, 1.1)
    assert not change.slower
    assert change.ratio == 9.0
    assert math.isfinite(change.ratio_low)
    assert math.isfinite(change.ratio_high)


def test_two_rounds_that_were_not_slower_leave_doubt():
    # Of 15 rounds the interval of 999 in 1000 begins at the second: one stray round is noise.
    base = [1.0] * 15
    assert compare_samples(base, [1.0, *[2.0] * 14], 1.1).slower
    assert not compare_samples(base, [1.0, 1.0, *[2.0] * 13], 1.1).slower


def test_a_slow_moment_of_the_machine_hits_both_sides_of_a_round():
    base = [1.0 * (1 + k) for k in range(15)]
    change = compare_samples(base, base, 1.1)
    assert change.ratio == change.ratio_low == change.ratio_high == 1.0
    assert not change.slower


def test_slower_than_the_threshold_means_more_than_it():
    assert not compare_samples([1.0] * 15, [1.1] * 15, 1.1).slower


@given(st.lists(st.tuples(st.floats(0.1, 10), st.floats(0.1, 10)), min_size=1, max_size=30))
def test_both_ways_round_only_one_side_can_be_slower(pairs):
    base, head = zip(*pairs, strict=True)
    there, back = compare_samples(base, head, 1.05), compare_samples(head, base, 1.05)
    assert not (there.slower and back.slower)
    assert there.ratio_low <= there.ratio <= there.ratio_high


def test_a_round_that_one_side_lacks_is_a_bug():
    with pytest.raises(ValueError, match="zip"):
        compare_samples([1.0, 1.0], [1.0], 1.1)


# --- another day ------------------------------------------------------------------------------

KNOWN = SceneTimes(median=1.0, low=0.9, high=1.1, samples=75, noise=1.05, threshold=1.2)


def test_another_day_counts_where_the_whole_interval_is_slower():
    slow = compare_times(Timing(median=2.0, low=1.5, high=2.5, samples=15), KNOWN)
    assert slow.slower
    assert slow.ratio == 2.0
    assert "2.00 times as long as when this machine was calibrated" in slow.words
    doubtful = compare_times(Timing(median=2.0, low=1.3, high=2.5, samples=15), KNOWN)
    assert not doubtful.slower
    assert doubtful.words == ""


def test_a_machine_that_was_not_calibrated_says_how():
    change = compare_times(Timing(median=2.0, low=1.5, high=2.5, samples=15), None)
    assert not change.slower
    assert change.base is None
    assert "`ghostball calibrate`" in change.words


# --- the file of a machine --------------------------------------------------------------------

TIMES = MachineTimes(
    machine="a-machine", environment={"cpu": "a", "versions": {}}, processes=2, scenes={"s": KNOWN}
)


def test_times_read_back(tmp_path):
    path = tmp_path / "machines" / "a.toml"
    assert load_times(path) is None
    save_times(TIMES, path)
    assert load_times(path) == TIMES
    assert [one.name for one in path.parent.iterdir()] == ["a.toml"]


@pytest.mark.parametrize(
    ("pattern", "replacement", "said"),
    [
        ("median = 1.0", "median = -1.0", "`scenes.s.median` must be greater than 0, got -1.0"),
        ("median = 1.0", "median = nan", "`scenes.s.median`"),
        ("threshold = 1.2", "threshold = 0.5", "`scenes.s.threshold` must be greater than 1"),
        ("noise = 1.05", "", "`scenes.s.noise` is missing. "),
        ('machine = "a-machine"', "", "`machine` is missing. "),
        ("processes = 2", "processes = 1", "`processes` must be greater than or equal to 2, got 1"),
        ("schema = 1", "schema = 2", "`schema` must be 1, got 2"),
        ("schema = 1", "schema = ", "can't be read"),
        ("samples = 75", "samples = 75\nfast = true", "`scenes.s.fast`"),
    ],
)
def test_a_damaged_file_says_what_to_do(tmp_path, pattern, replacement, said):
    path = tmp_path / "a.toml"
    save_times(TIMES, path)
    text = path.read_text(encoding="utf-8")
    assert pattern in text
    path.write_text(text.replace(pattern, replacement), encoding="utf-8")
    with pytest.raises(TimesError, match=re.escape(said)) as raised:
        load_times(path)
    assert str(raised.value).startswith(f"{path}: ")
    assert str(raised.value).endswith("Remove it and run `ghostball calibrate`")
    assert len(str(raised.value)) < len(str(path)) + 200, "shows the whole file"


def test_what_cannot_be_written_is_told_and_leaves_nothing(tmp_path):
    (tmp_path / "machines").write_text("in the way")
    with pytest.raises(TimesError, match=r"can't be written: .* Choose another `--baselines`"):
        save_times(TIMES, tmp_path / "machines" / "a.toml")
    assert [one.name for one in tmp_path.iterdir()] == ["machines"]


def test_each_machine_has_a_file_of_its_own(tmp_path):
    environment = bench_environment("AMD EPYC 7R13")
    path = times_path(tmp_path, environment)
    assert path.parent == tmp_path / "machines"
    assert path != times_path(tmp_path, bench_environment("Intel Xeon"))


def bench_environment(cpu):
    return {**measured_where(), "cpu": cpu}


# --- timing -----------------------------------------------------------------------------------


def test_scenes_are_timed_by_turns(monkeypatch):
    taken = []

    def run(scene):
        taken.append(scene.name)
        return gate_result(1e-5 * (1 + taken.count(scene.name)))

    monkeypatch.setattr(timing, "run", run)
    scenes = [gate.roll_shot(name="a"), gate.roll_shot(name="b")]
    found = time_scenes(scenes, rounds=3)
    assert set(found) == {"a", "b"}
    assert all(one.samples == 3 for one in found.values())
    # After a warm-up each, a sample of one lies between those of the other.
    sides = "".join(taken).replace("a" * timing.RUNS, "A").replace("b" * timing.RUNS, "B")
    assert re.search("A.*B.*A.*B|B.*A.*B.*A", sides), sides


def gate_result(seconds):
    return replace(simulate(gate.roll_shot()), wall_time=seconds)


def test_an_interrupt_leaves_no_half_measurement(monkeypatch):
    class Stopped:
        interrupted = True

    monkeypatch.setattr(timing, "take_turns", lambda *_, **__: Stopped())
    with pytest.raises(KeyboardInterrupt):
        time_scenes([gate.roll_shot()])
