"""The family of flight: its judges see what they are for."""

from ghostball.engine import simulate
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families import flight
from ghostball.validation.stress.families.flight import (
    FAMILY,
    Jumps,
    Lands,
    SoundInSpace,
    endless,
    on_top,
    over_the_top,
)


def test_a_clip_of_the_top_is_told_from_a_miss():
    for depth in (1e-3, -1e-3):
        result = simulate(over_the_top(depth, 0.3), record="trajectory")
        assert SoundInSpace(meets=depth > 0.0)(result).faults == ()
        fault = SoundInSpace(meets=depth < 0.0)(result).faults[0]
        assert ("that don't" if depth > 0.0 else "pass through") in fault


def test_what_overlaps_in_space_is_seen(monkeypatch):
    result = simulate(on_top(1.5, 0.0, 0.1), record="trajectory")
    assert SoundInSpace()(result).faults == ()
    monkeypatch.setattr(flight, "SUNK", -1e-3)
    assert "overlap of balls" in SoundInSpace()(result).faults[0]


def test_bounces_that_end_late_are_seen():
    scene = endless(2, 0.6, 0.1)
    result = simulate(scene, record="trajectory")
    ends = 0.57113724917082579
    assert Lands(ends)(result).faults == ()
    assert "off by" in Lands(1.0000001 * ends)(result).faults[0]


def test_random_jumps_hold_and_a_storm_is_seen(monkeypatch):
    engine = make_engine("ghostball")
    verdict = Jumps("few", 0, 12).run(engine)
    assert verdict.faults == ()
    assert verdict.shots == 12
    monkeypatch.setattr(flight, "MOST_EVENTS", 3)
    assert Jumps("few", 0, 12).run(engine).broken > 0


def test_the_quick_trials_are_among_the_full_ones_or_of_their_kind():
    quick = {trial.name for trial in FAMILY.trials("quick") if not isinstance(trial, Jumps)}
    assert quick <= {trial.name for trial in FAMILY.trials("full")}
