"""Variants of the kernels: what a scene needs is in the one that it gets."""

from __future__ import annotations

from itertools import product

import pytest

from ghostball.engine.running.variants import Variant, still_scene, variant_of

EVERY = [Variant(*parts) for parts in product((False, True), repeat=len(Variant._fields))]


@pytest.mark.parametrize("variant", EVERY)
def test_a_still_scene_asks_for_the_variant_that_it_warms(variant):
    assert variant_of(still_scene(variant)) == variant


def test_each_variant_has_a_name_of_its_own():
    assert len({one.name("shots") for one in EVERY}) == len(EVERY)
    assert Variant().name("shots") == "shots"
    assert Variant(drag=True, flight=True).name("sweeps") == "sweeps with air, flight"
