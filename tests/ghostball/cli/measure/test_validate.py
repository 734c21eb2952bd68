"""What `ghostball validate` plans to run."""

from __future__ import annotations

import pytest

from ghostball.cli.measure.validate import _plan


@pytest.mark.parametrize(
    ("scenes", "metrics", "whole"),
    [
        ((), (), True),
        (("full",), (), True),  # as `make validate` asks
        (("stop", "full"), (), True),
        (("stop",), (), False),
        (("full",), ("energy_drift",), False),
    ],
)
def test_engines_are_put_beside_real_tables_where_all_scenes_are_asked(scenes, metrics, whole):
    assert _plan(scenes, (), None, metrics, None, None, True).whole == whole
