"""What the common criteria hold against a grade: for whoever grades outside the suite."""

from __future__ import annotations

from ghostball.model import Scene
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.checks.criteria import common_criteria
from ghostball.validation.grading.grading import Grade


def faults_of(grade: Grade, scene: Scene) -> tuple[str, ...]:
    """Return which limits a grade breaks that hold for what claims to err by rounding alone.

    One sentence each; a metric without a value breaks none.
    """
    values = {
        "events_missing": len(grade.missing),
        "events_invented": len(grade.invented),
        "event_time_error_ulps": grade.time_error_max,
        "quality_factor": grade.quality_factor,
    }
    broken = [
        criterion
        for criterion in common_criteria().applying_to(OURS, {}, "rounding")
        if (value := values.get(criterion.metric)) is not None and not criterion.allows(value)
    ]
    faults = [
        f"{criterion.metric} is {values[criterion.metric]:.6g}, {criterion.limit_kind} "
        f"{criterion.limit:g}"
        for criterion in broken
    ]
    if grade.first is not None and faults:
        faults.append(grade.first.describe(scene))
    return tuple(faults)
