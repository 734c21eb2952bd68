"""Hashes of a long log: another event, another hash of its block alone."""

from __future__ import annotations

import gate
import pytest

from ghostball.validation.baselines.fingerprint import BLOCK, blocks_of


@pytest.mark.parametrize(("count", "blocks"), [(0, 0), (1, 1), (BLOCK, 1), (BLOCK + 1, 2)])
def test_a_log_has_a_hash_for_each_block(count, blocks):
    assert len(blocks_of(gate.long_log(count))) == blocks


def test_an_event_changes_the_hash_of_its_block_alone():
    events = gate.long_log(3 * BLOCK)
    before = blocks_of(events)
    events["t"][BLOCK] += 0.5
    after = blocks_of(events)
    assert [a == b for a, b in zip(before, after, strict=True)] == [True, False, True]
    assert before[1].sequence == after[1].sequence
