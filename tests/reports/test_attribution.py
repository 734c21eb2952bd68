"""How the parts of a difference are written."""

from dataclasses import replace

from ghostball.reports.attribution_text import (
    backward_text,
    better_text,
    ladder_text,
    part_text,
    share_text,
)
from ghostball.validation.diagnose.attribution import Attribution, BackwardError, Better, Part

STROKE = BackwardError("cue", -1e-3, -5.2e-5, 4e-4, 3)
DIVIDED = Attribution(
    "stop",
    "pymunk",
    "pymunk",
    "attributed",
    "certified",
    difference=4e-3,
    model=Part(1e-3, 2e-4, 0.25),
    discretisation=Part(3e-3, 2e-4, 0.75),
    rounding=1e-15,
    step=1e-3,
    finest=1e-3 / 64,
    runs=20,
    better=(Better("dt", 1e-3 / 64, 2e-4), Better("mode", "landed", 6e-6)),
    backward=STROKE,
)


def test_a_part_has_its_bound_and_one_that_may_be_none_only_that():
    assert part_text(DIVIDED.model) == "1 mm ± 200 µm"
    assert part_text(Part(1e-3, 2e-3, -0.32)) == "at most 3 mm, not told from none"
    assert part_text(None) == "–"


def test_shares_are_given_where_both_parts_are_told_and_none_is_negative():
    assert share_text(DIVIDED) == "25 % model, 75 % step"
    assert share_text(replace(DIVIDED, model=Part(1e-3, 2e-3, 0.25))) == ""
    assert share_text(replace(DIVIDED, discretisation=None)) == ""
    apart = replace(DIVIDED, model=Part(1e-3, 2e-4, -0.32), discretisation=Part(3e-3, 2e-4, 1.32))
    assert "%" not in share_text(apart)
    assert "hide each other" in share_text(apart)


def test_the_ladder_says_how_many_runs_and_which_steps():
    assert ladder_text(DIVIDED) == "20 runs with steps from 1 ms to 15.6 µs"
    assert ladder_text(replace(DIVIDED, step=None)) == ""


def test_what_plays_it_better_is_advised():
    measured = "`dt=1.56e-05` is 200 µm off; `mode=landed` is 6 µm off"
    assert better_text(DIVIDED) == measured
    open_ = replace(DIVIDED, model=Part(5e-3, 1e-2, 0.1))
    assert better_text(open_) == (
        f"{measured}; a step of 1.56 µs would bring it within 1 mm of its end at zero step"
    )
    lacking = replace(DIVIDED, model=Part(5e-2, 1e-2, 0.9), better=())
    assert better_text(lacking) == "no step brings it nearer than 40 mm"


def test_the_stroke_is_in_a_players_words():
    assert backward_text(DIVIDED) == (
        "as if played 0.003° to the right and 0.1 % softer; 400 µm of 4 mm is left unexplained"
    )
    other = replace(STROKE, speed=0.02, turn=0.0)
    assert "as if played 2 % harder;" in backward_text(replace(DIVIDED, backward=other))
    still = replace(STROKE, speed=0.0, turn=0.0)
    assert "no other speed or direction" in backward_text(replace(DIVIDED, backward=still))
    assert backward_text(replace(DIVIDED, backward=None, no_backward="two are fast")) == (
        "two are fast"
    )
