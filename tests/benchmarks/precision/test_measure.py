"""Fails where a point, a time or a reason is wrong, or an interrupt loses what was measured."""

import pytest
from toy_engines import NoSettings, ToyEngine, ToySettings, cut, other_shot, roll

from benchmarks.measurements import load, save
from benchmarks.precision import measure as precision
from benchmarks.precision._ladders import TINY, Extent
from benchmarks.precision.measure import measure_precision
from benchmarks.precision.points import PrecisionMeasurement, reach_of
from ghostball.engine import UnsupportedSceneError
from ghostball.reference_adapters import EngineBase, EngineError, EngineUnavailableError
from ghostball.validation.scenes.library import find_scene

FEW = Extent(most_steps=4_000)


@pytest.fixture
def engines(monkeypatch):
    """Engines by label, instead of those that are installed."""
    made = {}
    honest = precision.make_engine
    monkeypatch.setattr(
        precision,
        "make_engine",
        lambda label: made[label] if label in made else honest(label),
    )
    return made


def measure(labels, scenes=None, *, rounds=2, extent=FEW, **options):
    return measure_precision(scenes or [roll()], labels, rounds=rounds, extent=extent, **options)


@pytest.mark.parametrize(("order", "slope"), [(1.0, 0.3), (2.0, 20.0)])
def test_the_planted_error_is_found(engines, order, slope):
    engines["toy"] = ToyEngine(ToySettings(slope=slope, order=order))
    measured = measure(["toy"])
    for point in measured.points:
        assert point.error == pytest.approx(slope * point.step**order, rel=1e-9)
        assert (point.engine, point.exact, point.samples) == ("toy", False, 2)
    steps = [point.step for point in measured.points]
    assert steps == sorted(steps, reverse=True)
    (curve,) = measured.curves
    assert [reach.target for reach in curve.reach] == [1e-3, 1e-6, 1e-9]
    near = [point.seconds for point in measured.points if point.error_high <= 1e-3]
    assert curve.reach[0].seconds == min(near)
    assert curve.reach[2].seconds is None


def test_the_phases_of_a_step_are_the_error_bar(engines):
    engines["toy"] = ToyEngine(ToySettings(sawtooth=0.5, dt=0.013))
    (point, *_) = measure(["toy"], rounds=4, extent=TINY).points
    assert point.error_low < point.error < point.error_high
    # Four phases of a sawtooth of height 0.5 h.
    assert point.error_high - point.error_low == pytest.approx(0.75 * 0.5 * 0.013, rel=1e-6)


def test_what_ends_beside_the_truth_reaches_nothing_nearer(engines):
    engines["toy"] = ToyEngine(ToySettings(model=3e-3, slope=0.3))
    (curve,) = measure(["toy"]).curves
    assert [reach.seconds for reach in curve.reach] == [None] * 3


def test_a_step_that_is_good_by_luck_does_not_count(engines):
    engines["toy"] = ToyEngine(ToySettings(slope=0.3))
    points = measure(["toy"]).points
    lucky = points[0].model_copy(update={"error_high": 0.0, "seconds": 0.0})
    assert reach_of(1e-3, [lucky, *points[1:]]) == reach_of(1e-3, points)
    assert reach_of(1e-3, [lucky]).seconds == 0.0
    assert reach_of(1e-3, [lucky], lost=[1e-3]).seconds is None


def test_our_engine_is_a_point_beside_the_ladders(engines):
    engines["toy"] = ToyEngine(ToySettings(slope=0.3))
    measured = measure(["ghostball", "toy", "certified"])
    ours = next(point for point in measured.points if point.engine == "ghostball")
    assert (ours.exact, ours.step, ours.work_name) == (True, None, "events")
    assert ours.error < 1e-15
    assert ours.truth == "closed form" or {"certified"} == {
        one.engine for one in measured.left_out if "the truth here" in one.why
    }


def test_an_engine_that_plays_another_shot_has_a_point_that_says_so(engines):
    engines["other"] = other_shot(turn=0.5)
    (point,) = measure(["other"], [cut()]).points
    assert not point.true_course
    assert point.exact


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
    measured = measure(["lacks", "exits", "absent", "pymunk:max_time=0.5"], extent=TINY)
    assert measured.points == ()
    assert not measured.anything
    whys = {one.engine.partition(",dt")[0]: one.why for one in measured.left_out}
    assert whys["lacks"] == "not representable: no balls"
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


def test_an_interrupt_keeps_what_is_done(engines):
    engines["toy"] = ToyEngine(ToySettings(slope=0.3))
    done = []

    def stop(count, planned, last):
        done.append(last)
        if len(done) == 8:
            raise KeyboardInterrupt

    measured = measure(["toy", "ghostball"], progress=stop)
    assert measured.interrupted
    assert 1 < len(measured.points) < 6
    assert {curve.engine for curve in measured.curves} == {"toy", "ghostball"}


def test_what_is_stored_reads_back(engines, tmp_path):
    engines["toy"] = ToyEngine(ToySettings(slope=0.3))
    measured = measure(["ghostball", "toy"])
    save(measured, tmp_path / "precision.json", "--out")
    assert load(tmp_path / "precision.json", PrecisionMeasurement) == measured


def test_a_real_engine_errs_by_half_at_half_the_step_and_landing_is_near_at_any():
    measured = measure(["paper-continuous", "pymunk:mode=landed"], [find_scene("half-ball-cut")])
    stepping = [p.error for p in measured.points if p.engine == "paper-continuous"]
    assert stepping[-2] / stepping[-1] == pytest.approx(2.0, abs=0.1)
    landed = next(curve for curve in measured.curves if curve.engine == "pymunk:mode=landed")
    assert landed.reach[1].seconds is not None
