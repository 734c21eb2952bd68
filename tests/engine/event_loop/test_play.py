"""Tests of the numbers that a kernel gets, after it unpacks them."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine.core.rows import OBSTACLE
from ghostball.engine.core.state import Laws
from ghostball.engine.event_loop.play import laws_from

NUMBERS = Laws._fields[:-1]
NOTHING = Laws(*(0.0,) * len(NUMBERS), obstacles=np.empty(0, dtype=OBSTACLE))


@pytest.mark.parametrize("name", NUMBERS)
def test_laws_come_out_of_the_kernels_numbers_as_they_went_in(name):
    """Fails if a field is added to `Laws` but not to `laws_from`."""
    laws = NOTHING._replace(**{name: 1.0})
    found = laws_from(np.array(laws[:-1], dtype=np.float64), laws.obstacles)
    assert [field for field in NUMBERS if getattr(found, field) != 0.0] == [name]
    assert len(found) == len(Laws._fields)
