"""Points, times and reasons of measurements are right, and an interrupt loses no measurement."""

import pytest
from toy_engines import NoSettings, ToyEngine, ToySettings, cut, other_shot, roll

from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters import (
    EngineBase,
    EngineError,
    EngineUnavailableError,
    make_engine,
)
from ghostball.validation.precision import measure as precision
from ghostball.validation.precision.measure import ladder_of, measure_precision
from ghostball.validation.precision.points import PrecisionMeasurement, seconds_to
from ghostball.validation.runs import time_steps
from ghostball.validation.runs.time_steps import step_of
from ghostball.validation.scenes.library import find_scene


@pytest.fixture(autouse=True)
def _short_ladders(monkeypatch):
    monkeypatch.setattr(time_steps, "MOST_STEPS", 4_000)


@pytest.fixture
def engines(monkeypatch):
    """Return a dict of engines by label that replace installed engines."""
    made = {}
    honest = precision.make_engine
    monkeypatch.setattr(
        precision,
        "make_engine",
        lambda label: made[label] if label in made else honest(label),
    )
    return made


@pytest.mark.parametrize(
    "label", ["pymunk:contact_steps=exact,iterations=3", "paper-continuous:frame=0.01"]
)
def test_labels_make_the_engine_with_the_step(label):
    own = make_engine(label)
    points = list(ladder_of(label, own, 4.0))
    assert step_of(own) in [point.step for point in points]
    for point in points:
        assert point.family == label
        assert make_engine(point.label).settings == point.engine.settings
        assert step_of(point.engine) == point.step


def measure(labels, scenes=None, *, rounds=2):
    return measure_precision(scenes or [roll()], labels, rounds=rounds)


@pytest.mark.parametrize(("order", "slope"), [(1.0, 0.3), (2.0, 20.0)])
def test_the_planted_error_is_found(engines, order, slope):
    engines["toy"] = ToyEngine(ToySettings(slope=slope, order=order))
    measured = measure(["toy"])
    for point in measured.points:
        assert point.error == pytest.approx(slope * point.step**order, rel=1e-9)
        assert (point.engine, point.samples) == ("toy", 2)
    steps = [point.step for point in measured.points]
    assert steps == sorted(steps, reverse=True)
    near = [point.call_seconds for point in measured.points if point.error_high <= 1e-3]
    assert seconds_to(1e-3, measured.points) == min(near)
    assert seconds_to(1e-9, measured.points) is None


def test_a_whole_call_takes_at_least_what_the_engine_reports(engines):
    """Fails if the time of one engine excludes the call, but that of another includes it."""
    for point in measure(["ghostball", "pymunk:dt=5e-3"]).points:
        assert 0.0 < point.seconds <= point.call_seconds


def test_the_phases_of_a_step_are_the_error_bar(engines):
    engines["toy"] = ToyEngine(ToySettings(sawtooth=0.5, dt=0.013))
    (point, *_) = measure(["toy"], rounds=4).points
    assert point.error_low < point.error < point.error_high
    # Four phases of a sawtooth with the height 0.5 dt.
    assert point.error_high - point.error_low == pytest.approx(0.75 * 0.5 * 0.013, rel=1e-6)


def test_what_ends_beside_the_truth_reaches_nothing_nearer(engines):
    engines["toy"] = ToyEngine(ToySettings(model=3e-3, slope=0.3))
    assert seconds_to(1e-3, measure(["toy"]).points) is None


def test_our_engine_is_a_point_beside_the_ladders(engines):
    engines["toy"] = ToyEngine(ToySettings(slope=0.3))
    measured = measure(["ghostball", "toy", "certified"])
    ours = next(point for point in measured.points if point.engine == "ghostball")
    assert ours.step is None
    assert ours.error < 1e-15
    assert ours.truth == "closed form" or {"certified"} == {
        one.engine for one in measured.left_out if "the reference here" in one.why
    }


def test_an_engine_that_plays_another_shot_has_a_point_that_says_so(engines):
    engines["other"] = other_shot(turn=0.5)
    (point,) = measure(["other"], [cut()]).points
    assert not point.same_events


class _Lacks(EngineBase):
    name = "lacks"
    Settings = NoSettings

    @property
    def capabilities(self):
        return {}

    def simulate(self, scene, *, record="rest"):
        raise UnsupportedSceneError(self.name, ["no balls"])


class _Exits(_Lacks):
    def simulate(self, scene, *, record="rest"):
        raise SystemExit("gone")


def test_what_cannot_be_measured_is_left_out_with_its_reason(engines, monkeypatch):
    engines["lacks"], engines["exits"] = _Lacks(), _Exits()
    honest = precision.make_engine

    def make(label):
        if label == "absent":
            raise EngineUnavailableError("not installed. pip install it")
        return honest(label)

    monkeypatch.setattr(precision, "make_engine", make)
    measured = measure(["lacks", "exits", "absent", "pymunk:max_time=0.5"])
    assert measured.points == ()
    whys = {one.engine: one.why for one in measured.left_out}
    assert whys["lacks"] == "unsupported: no balls"
    assert whys["exits"] == "failed: SystemExit: gone"
    assert whys["absent"].startswith("unavailable: not installed")
    assert "stopped early" in whys["pymunk:max_time=0.5"]
    assert "`max_time`" in whys["pymunk:max_time=0.5"]


@pytest.mark.parametrize(
    ("label", "said"),
    [
        ("nosuch", "nosuch"),
        ("pymunk:dt=-1", "`dt`"),
        ("pymunk:dt=nan", "`dt`"),
        ("ghostball:dt=1", "`dt` is not a setting"),
    ],
)
def test_an_engine_or_a_step_that_is_refused_is_an_error(label, said):
    with pytest.raises(EngineError, match=said):
        measure([label])


def test_what_is_stored_reads_back(engines, tmp_path):
    engines["toy"] = ToyEngine(ToySettings(slope=0.3))
    measured = measure(["ghostball", "toy"])
    assert PrecisionMeasurement.load(measured.save(tmp_path)) == measured


def test_a_real_engine_errs_by_half_at_half_the_step_and_exact_steps_are_near_at_any():
    measured = measure(
        ["paper-continuous", "pymunk:contact_steps=exact"], [find_scene("half-ball-cut")]
    )
    stepping = [p.error for p in measured.points if p.engine == "paper-continuous"]
    assert stepping[-2] / stepping[-1] == pytest.approx(2.0, abs=0.1)
    exact = [point for point in measured.points if point.engine == "pymunk:contact_steps=exact"]
    assert seconds_to(1e-6, exact) is not None
