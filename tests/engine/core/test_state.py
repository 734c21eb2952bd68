"""The engine's rows of numbers, as others read them."""

from ghostball.engine.core import state
from ghostball.model.trajectory import Phase, segment


def test_a_ball_moves_by_the_numbers_that_the_model_reads():
    """Breaks where one of the two is put in another order: recorded motions are heads of rows."""
    assert state.BALL_FIELDS[: state.SEGMENT_COLUMNS] == segment.NAMES
    for name in segment.NAMES:
        assert getattr(state, name.upper()) == getattr(segment, name.upper())
    for phase in Phase:
        assert getattr(state, phase.name) == phase
