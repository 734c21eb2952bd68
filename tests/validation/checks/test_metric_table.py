"""Metrics are chosen by name and pattern."""

from __future__ import annotations

import pytest

from ghostball.validation.checks.metric_table import METRICS, MetricError, choose_metrics


@pytest.mark.parametrize(
    ("patterns", "names"),
    [
        (["wall_time", "rest_error_max"], ("rest_error_max", "wall_time")),
        (
            ["rest_error_*", "rest_error_m?x"],
            ("rest_error_max", "rest_error_rms", "rest_error_ulps"),
        ),
        (["*"], tuple(METRICS)),
    ],
)
def test_metrics_are_chosen_by_name_and_pattern(
    patterns: list[str], names: tuple[str, ...]
) -> None:
    assert choose_metrics(patterns) == names


@pytest.mark.parametrize(
    ("patterns", "message"),
    [
        (["rest_eror_max"], "Did you mean `rest_error_max`"),
        (["wall_time", "speed_*"], "got 'speed_\\*'.*Known: rest_error_max, rest_error_rms"),
        (["wall_time", ""], "got ''"),
        (["WALL_TIME"], "got 'WALL_TIME'"),
        ([], "at least one metric"),
    ],
)
def test_a_choice_that_names_no_metric_is_refused(patterns: list[str], message: str) -> None:
    with pytest.raises(MetricError, match=message):
        choose_metrics(patterns)
