"""Motions of cases: read back to the bit, named where they are damaged."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from stored_cases import in_database, motion, record, written

from ghostball.model import EVENT_DTYPE
from ghostball.validation.results.motions import stored_hashes
from ghostball.validation.results.store import (
    Motion,
    Results,
    ResultsError,
)


def test_a_motion_reads_back_to_the_bit(tmp_path: Path) -> None:
    written(tmp_path, record())
    folder = Results.open(tmp_path)
    read = folder.motion(folder.cases[0])
    assert read is not None
    for part in fields(Motion):
        assert getattr(read, part.name).tobytes() == getattr(motion(), part.name).tobytes()
    assert read.events.dtype == EVENT_DTYPE
    parts = (read.energy_translation, read.energy_rotation, read.energy_height)
    assert np.array_equal(read.energy, sum(parts))


def test_a_case_that_is_no_text_is_named(tmp_path: Path) -> None:
    written(tmp_path, record())
    in_database(tmp_path, "UPDATE records SET record = x'00' WHERE kind = 'case'")
    with pytest.raises(ResultsError, match="a case is damaged"):
        stored_hashes(tmp_path)


def test_a_damaged_motion_is_named(tmp_path: Path) -> None:
    written(tmp_path, record())
    folder = Results.open(tmp_path)
    in_database(tmp_path, "UPDATE motions SET content = substr(content, 1, 100)")
    with pytest.raises(ResultsError, match=r'the motion of `pymunk` in scene "roll" is damaged'):
        folder.motion(folder.cases[0])


def test_the_hash_of_a_case_is_of_its_record_its_motion_and_its_events(tmp_path: Path) -> None:
    written(tmp_path, record())
    hashes = [stored_hashes(tmp_path)]
    assert list(hashes[0]) == ['["roll", "pymunk"]']
    in_database(tmp_path, "UPDATE records SET reused = 1")
    assert stored_hashes(tmp_path) == hashes[0]
    for change in (
        "UPDATE records SET record = replace(record, 'roll', 'rolls')",
        "UPDATE events SET t = t + 1e-15",
        "UPDATE motions SET content = x''",
        "DELETE FROM motions",
        "UPDATE records SET current = 0",
    ):
        in_database(tmp_path, change)
        hashes.append(stored_hashes(tmp_path))
    assert all(one not in hashes[:k] for k, one in enumerate(hashes))
