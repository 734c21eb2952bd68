"""The lines of a baseline read back as what was written, to the bit: TOML, and each event."""

import tomllib

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pydantic_core import PydanticCustomError

from ghostball.model import EVENT_DTYPE, OBSTACLE_KINDS, EventKind
from ghostball.validation.baselines.baseline_text import (
    events_of_lines,
    line_of,
    line_of_event,
    toml_lines,
)


@pytest.mark.parametrize("kind", EventKind)
def test_an_event_reads_back_to_the_bit(kind):
    b = 7 if kind is EventKind.BALL_BALL else 1 if kind in OBSTACLE_KINDS else -1
    events = np.array([(0.1 + 0.2, kind, 3, b)], dtype=EVENT_DTYPE)
    line = line_of_event(events[0])
    assert line.startswith(f"0.30000000000000004 {kind.label} 3")
    assert events_of_lines((line,)).tobytes() == events.tobytes()


@pytest.mark.parametrize("line", ["", "x ball-ball 0 1", "1.0 ball-ball 0", "1.0 roll-to-rest -1"])
def test_what_is_no_event_is_refused_with_its_place(line):
    with pytest.raises(PydanticCustomError, match=r"`events.first\[1\]` must be an event such as"):
        events_of_lines(("0.5 ball-ball 0 1", line))


NUMBER = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(2**53), 2**53)
KEY = st.text('ab-_ ."\\é\x7f', min_size=1)


@given(st.dictionaries(KEY, NUMBER | st.text() | st.lists(NUMBER) | st.dictionaries(KEY, NUMBER)))
def test_fields_read_back_as_they_were(fields):
    read = tomllib.loads("\n".join(toml_lines(fields)))
    assert repr(read) == repr(fields)


def test_texts_of_a_list_are_a_line_each_and_a_field_is_found_by_its_line():
    text = "\n".join(toml_lines({"count": 2, "first": ("a", "b")}))
    assert text == 'count = 2\nfirst = [\n    "a",\n    "b",\n]'
    assert [line_of(text, name) for name in ("count", "first", "none")] == [1, 2, 1]
