"""Tests of the variants of the kernels: each scene gets a variant with all that it needs."""

from __future__ import annotations

import pytest

from ghostball.engine.running.variants import Variant, still_scene, variant_of


@pytest.mark.parametrize("variant", Variant)
def test_a_still_scene_asks_for_the_variant_that_it_warms(variant):
    assert variant_of(still_scene(variant)) == variant
