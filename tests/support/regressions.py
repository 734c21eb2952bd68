"""Comparisons written by hand, for whatever shows them."""

from ghostball.validation.baselines import (
    FirstDifference,
    Quantity,
    Regression,
    SceneChange,
)


def quantity(name="energy_rise", *, level="error", within=True, base=0.0, head=0.0, **band):
    return Quantity(
        name=name,
        unit="1",
        base=base,
        head=head,
        level=level,
        within=within,
        why="as accepted",
        **band,
    )


def identical(scene="stop", **changes):
    fields = {
        "scene": scene,
        "title": "One ball",
        "change": "identical",
        "failed": False,
        "summary": "not a bit differs",
        "base_hash": "a" * 64,
        "head_hash": "a" * 64,
        "metrics": (quantity(low=0.0, high=1e-14),),
        "counters": (quantity("events", base=3, head=3, low=3, high=3),),
        "command": f"ghostball run {scene}",
    }
    return SceneChange(**fields | changes)


def worse(scene="break-7", **changes):
    """A scene that fails: one collision is missing, and a counter is out of its band."""
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
        "metrics": (quantity("rest_error_max", within=False, base=7e-15, head=3e-3, high=1e-12),),
        "counters": (
            quantity("roots", level="warn", within=False, base=10, head=12, low=10, high=10),
            quantity("bounds", level="off", base=10, head=12),
        ),
    }
    return identical(scene, **fields | changes)


def uncompared(scene="head-on", **changes):
    fields = {"failed": False} | changes
    return identical(
        scene,
        change="no-baseline",
        summary="no baseline was accepted",
        base_hash="",
        metrics=(),
        counters=(),
        command=f"ghostball regress {scene}",
        **fields,
    )


def regression(*scenes, outcome="failed", **changes):
    fields = {"base": {}, "head": {}, "outcome": outcome, "scenes": scenes}
    return Regression(**fields | changes)
