"""Our engine on every shipped scene, graded by its proof: what `validate` holds it to."""

from __future__ import annotations

import pytest

from ghostball.engine import simulate
from ghostball.engine.sensitivity import QUALITY
from ghostball.validation.checks.criteria import common_criteria
from ghostball.validation.checks.metrics import measure
from ghostball.validation.grading.tolerances import ROUNDINGS
from ghostball.validation.scenes.library import find_scene, scene_names
from ghostball.validation.truth.scene_truth import truth_of

GRADED = ("events_missing", "events_invented", "quality_factor")

NOTHING_PROVED = {"corner-exact", "three-ball-symmetric", "push", "wedged"}
"""Scenes in which what comes first is a tie, or a contact from the start."""

REFUSED = {"mathavan-cut": "no ball impacts after Mathavan 2014"}
"""Scenes of which nothing can be proved, and why; their own criteria hold them to other truths."""

LONG = {"galperin-4"}
"""Scenes whose proof takes half a minute; `ghostball validate` holds them to the same limits."""

_NOT_PROVED = "nothing of this shot is proved"


@pytest.mark.parametrize("name", [name for name in scene_names() if name not in LONG])
def test_our_engine_keeps_the_limits_of_every_scene(name: str) -> None:
    # Breaks, too, where a scene is graded no more, though it could be.
    scene = find_scene(name)
    truth = truth_of(scene, parts=frozenset({"proof"}))
    measured = measure(simulate(scene, record="trajectory"), truth, GRADED)
    law = common_criteria().applying_to("ghostball", {}, "rounding")
    limits = {criterion.metric: criterion for criterion in law}
    for metric in GRADED:
        value = measured.values[metric]
        if name in NOTHING_PROVED or name in REFUSED:
            assert value is None
            why = f"no proof: {REFUSED[name]}" if name in REFUSED else _NOT_PROVED
            assert measured.notes[metric].startswith(why)
        else:
            assert value is not None, measured.notes
            assert limits[metric].allows(value)


def test_the_limit_on_the_quality_factor_is_what_the_engine_promises() -> None:
    # `Result.horizon` takes errors to stay within it.
    (limit,) = [c.limit for c in common_criteria().criteria if c.metric == "quality_factor"]
    assert limit == QUALITY == ROUNDINGS
