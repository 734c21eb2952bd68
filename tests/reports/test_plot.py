"""One result is drawn, without a folder of results."""

import pytest

from ghostball.reports import (
    plot_result,
)


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_one_result_is_drawn(result, tmp_path, ending):
    path = plot_result(result, tmp_path / f"shot.{ending}")
    assert path.stat().st_size > 5_000
