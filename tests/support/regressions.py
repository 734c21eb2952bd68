"""Comparisons with baselines, written by hand, for tests of reports."""

from ghostball.validation.baselines import (
    FirstDifference,
    Regression,
    SceneChange,
    ValueChange,
)


def quantity(name="events", *, unit="1", base=10, head=12):
    return ValueChange(name=name, unit=unit, base=base, head=head)


def unchanged(scene="stop", **changes):
    fields = {
        "scene": scene,
        "title": "One ball",
        "change": "unchanged",
        "summary": "bit-identical",
        "base_hash": "a" * 64,
        "head_hash": "a" * 64,
        "base_error": 1e-15,
        "head_error": 1e-15,
        "command": f"ghostball run {scene}",
    }
    return SceneChange(**fields | changes)


def worse(scene="break-7", **changes):
    """Return a change that fails: a collision is missing, and a counter differs."""
    fields = {
        "change": "worse",
        "failed": True,
        "summary": "rest error 3 mm, was 7 fm",
        "head_hash": "b" * 64,
        "first_difference": FirstDifference(
            index=1,
            before_horizon=True,
            words="event 1: cue meets 1 at t = 0.5 s, which is missing now",
        ),
        "base_error": 7e-15,
        "head_error": 3e-3,
        "metrics": (quantity("rest_error_max", unit="m", base=7e-15, head=3e-3),),
        "counters": (quantity("roots"),),
    }
    return unchanged(scene, **fields | changes)


def uncompared(scene="head-on", **changes):
    return unchanged(
        scene,
        change="no-baseline",
        summary="no baseline was accepted",
        base_hash="",
        command=f"ghostball regress {scene}",
        **changes,
    )


def regression(*scenes, outcome="failed", **changes):
    fields = {"head": {}, "outcome": outcome, "scenes": scenes}
    return Regression(**fields | changes)
