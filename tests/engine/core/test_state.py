"""Tests of the engine's rows of numbers, as other packages read them."""

from ghostball.engine.core import state
from ghostball.model.trajectory import Phase, segment


def test_a_ball_moves_by_the_numbers_that_the_model_reads():
    """Fails if columns are reordered on one side: a recorded motion is the start of a row."""
    assert state.BALL_FIELDS[: state.SEGMENT_COLUMNS] == segment.NAMES
    for name in segment.NAMES:
        assert getattr(state, name.upper()) == getattr(segment, name.upper())
    for phase in Phase:
        assert getattr(state, phase.name) == phase
