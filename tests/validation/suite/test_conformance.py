"""One engine compared with the suite, as by the plugin for pytest."""

from step_rules import limit_of_step

from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.conformance import (
    COMPLETES,
    Specs,
    asked_of_engine,
    requirement_names,
    run_scene,
)
from ghostball.validation.suite.plan import shipped_criteria

TOY = "toy_engines:ToyEngine"
HALF_BALL = find_scene("half-ball-cut")


def test_an_engine_judged_as_another_engine_gets_the_limits_of_its_step():
    # The limit is computed from pymunk's time step, although the toy engine declares rounding only.
    judged = Specs(TOY, "pymunk")
    own = shipped_criteria(HALF_BALL)
    asked = asked_of_engine(judged, own)
    assert requirement_names(judged, HALF_BALL, asked)[0] == COMPLETES
    assert "rest_error_max" in requirement_names(judged, HALF_BALL, asked)
    run = run_scene(judged, HALF_BALL, own, asked)
    (limit,) = [one.limit for one in run.record.checks if one.metric == "rest_error_max"]
    assert limit == limit_of_step(HALF_BALL, "pymunk")
    assert run.finding("rest_error_max").outcome == "passed"
    # Without a limit from the time step, the case is skipped.
    galperin = find_scene("galperin-2")
    asked = asked_of_engine(judged, Criteria())
    found = run_scene(judged, galperin, Criteria(), asked).finding("rest_error_max")
    assert found.outcome == "skipped"
    assert "no limit follows from the claims" in found.words
