"""Engines beside real tables: measured, kept beside the results, and read back."""

from __future__ import annotations

import pytest

from ghostball.model import GhostballError
from ghostball.validation.suite.real_tables import (
    FILE,
    forget_likenesses,
    load_likenesses,
    measure_likenesses,
)


def test_what_is_measured_is_read_back_until_it_is_forgotten(tmp_path):
    specs = ("ghostball", "pymunk:contact_steps=exact", "paper-discrete")
    found = measure_likenesses(specs, tmp_path, 60.0)
    assert [one.label for one in found] == list(specs)
    assert load_likenesses(tmp_path) == found
    forget_likenesses(tmp_path)
    assert load_likenesses(tmp_path) == []


def test_a_file_that_is_something_else_is_refused_by_name(tmp_path):
    (tmp_path / FILE).write_text('[{"label": "ghostball"}]')
    with pytest.raises(GhostballError, match=r"real-tables\.json: .*families"):
        load_likenesses(tmp_path)


def test_an_engine_that_fails_costs_its_own_figures(tmp_path):
    (one,) = measure_likenesses(["faulty_engine:FaultyEngine:does=raise"], tmp_path, 60.0)
    assert all(
        family.lacks.startswith("it failed: RuntimeError: lost the balls")
        for family in one.families
    )
