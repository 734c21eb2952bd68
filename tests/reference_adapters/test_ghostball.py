"""Ghostball's engine as a reference engine: its settings and their effects."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import GhostballError, Status
from ghostball.model.features import Feature
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.scenes.library import find_scene


def test_skips_are_named_in_order_and_change_nothing():
    engine = make_engine("ghostball:no_skip=records+advancement")
    assert engine.settings.no_skip == "advancement+records"
    scene = find_scene("half-ball-cut")
    assert np.array_equal(engine.simulate(scene).rest_positions, simulate(scene).rest_positions)


def test_what_names_no_skip_is_refused():
    with pytest.raises(GhostballError, match="must name skips, got 'cushion'"):
        make_engine("ghostball:no_skip=cushion")


def test_limits_end_a_run():
    scene = find_scene("break-7")
    assert make_engine("ghostball:max_events=5").simulate(scene).status is Status.EVENT_LIMIT
    assert make_engine("ghostball:max_work=100").simulate(scene).status is Status.WORK_LIMIT


def test_it_represents_every_feature_and_errs_by_rounding_alone():
    engine = make_engine("ghostball")
    assert set(engine.capabilities) == set(Feature)
    assert engine.resolution(find_scene("stop")) == 0.0
