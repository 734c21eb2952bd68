"""Statistical verdicts: rates of false alarms, detection of wrong engines, and texts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result as CliResult

from ghostball.cli import app
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reports.shared_tables import ensemble_words
from ghostball.validation.checks.metrics import measure
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene, select
from ghostball.validation.suite.ensemble import (
    MEMBER_METRICS,
    Ensemble,
    EnsembleError,
    PerturbationSize,
    varied,
)
from ghostball.validation.suite.statistics import (
    FALSE_ALARMS,
    QUANTITIES,
    REST_POSITIONS,
    EnsembleVerdict,
    QuantityVerdict,
    _energy_distance,
    _mean_distances,
    _permuted,
    compare_samples,
    ensemble_verdicts,
    holm,
    runs_needed,
)
from ghostball.validation.suite.suite import run_suite
from ghostball.validation.truth.scene_truth import Truth

BREAK = "pocket-break-9"
RUNS = 40


def runs(numbers: Sequence[int], change: Callable[[Scene], Scene] = lambda one: one) -> list[Any]:
    """Return the fields of records of a break from perturbed initial states."""
    found = []
    for number in numbers:
        scene = change(varied(find_scene(BREAK), PerturbationSize(), number))
        result = simulate(scene, record="trajectory")
        found.append(
            SimpleNamespace(
                collision_counts=result.collision_counts,
                rest_time=result.rest_time,
                rest_positions=result.rest_positions,
                metrics=measure(result, Truth(None), MEMBER_METRICS).values,
            )
        )
    return found


def different(one: list[Any], other: list[Any]) -> set[str]:
    return {q.name for q in compare_samples(one, other, sizes=False) if q.differs}


@pytest.fixture(scope="module")
def reference() -> list[Any]:
    return runs(range(RUNS))


def physics(**changed: Any) -> Callable[[Scene], Scene]:
    return lambda scene: scene.model_copy(
        update={"physics": scene.physics.model_copy(update=changed)}
    )


def cue_ball(**factors: float) -> Callable[[Scene], Scene]:
    def change(scene: Scene) -> Scene:
        cue = scene.balls[0]
        values = {name: np.multiply(getattr(cue, name), by) for name, by in factors.items()}
        plain = {name: value.tolist() for name, value in values.items()}
        cue = cue.model_copy(
            update={k: tuple(v) if isinstance(v, list) else v for k, v in plain.items()}
        )
        return scene.model_copy(update={"balls": (cue, *scene.balls[1:])})

    return change


def frictions(factor: float) -> Callable[[Scene], Scene]:
    def change(scene: Scene) -> Scene:
        return physics(rolling_friction=factor * scene.physics.rolling_friction)(scene)

    return change


WRONG_ENGINES: Mapping[str, Callable[[Scene], Scene]] = {
    "rolls too short": frictions(1.3),
    "rolls too far": frictions(0.8),
    "slides too far": physics(sliding_friction=0.1),
    "slides too short": physics(sliding_friction=0.4),
    "heavy": physics(gravity=1.2 * 9.81),
    "light": physics(gravity=0.8 * 9.81),
    "dull balls": physics(ball_restitution=0.8),
    "elastic balls": physics(ball_restitution=1.0),
    "no throw": physics(ball_friction=0.0),
    "rough balls": physics(ball_friction=0.3),
    "dull cushions": physics(cushion_restitution=0.7),
    "elastic cushions": physics(cushion_restitution=0.98),
    "smooth cushions": physics(cushion_friction=0.0),
    "a heavy cue ball": cue_ball(mass=1.5),
    "a light cue ball": cue_ball(mass=0.7),
    "a fast cue ball": cue_ball(velocity=1.1),
    "a slow cue ball": cue_ball(velocity=0.9),
    "air": physics(air_drag=0.05),
    "thick air": physics(air_drag=0.2),
    "a soft cloth": physics(rolling_friction_quadratic=0.2),
}


@pytest.mark.slow
@pytest.mark.parametrize("change", WRONG_ENGINES.values(), ids=WRONG_ENGINES.keys())
def test_a_wrong_engine_is_different(
    change: Callable[[Scene], Scene], reference: list[Any]
) -> None:
    assert different(runs(range(RUNS), change), reference)


@pytest.mark.slow
def test_an_engine_with_the_right_distributions_is_called_different_no_more_often_than_stated() -> (
    None
):
    """Compare our engine with itself 200 times, from independent initial states."""
    count, size = 200, 20
    pool = runs(range(600))
    random = np.random.default_rng(1)
    least = []
    for _ in range(count):
        order = random.permutation(len(pool))
        one, other = ([pool[k] for k in order[i * size : (i + 1) * size]] for i in (0, 1))
        least.append(min(q.p for q in compare_samples(one, other, sizes=False)))
    # By the binomial distribution, more alarms have a probability of 0.001 at the stated rates.
    assert sum(p < FALSE_ALARMS for p in least) <= 2
    assert sum(p < 0.05 for p in least) <= 20
    # A comparison that can't fail would have no such p.
    assert sum(p < 0.5 for p in least) > 20


FAULTS: Mapping[str, tuple[str, Callable[[Any], Any]]] = {
    "counts every collision of balls twice": (
        "ball-ball collisions",
        lambda run: {
            "collision_counts": run.collision_counts
            | {"ball-ball": 2 * run.collision_counts["ball-ball"]}
        },
    ),
    "misses every third cushion": (
        "ball-cushion collisions",
        lambda run: {
            "collision_counts": run.collision_counts
            | {"ball-cushion": 2 * run.collision_counts["ball-cushion"] // 3}
        },
    ),
    "rests late": ("rest time [s]", lambda run: {"rest_time": run.rest_time + 1.5}),
    "pockets two more": (
        "pocketed balls",
        lambda run: {
            "metrics": run.metrics | {"pocketed_count": run.metrics["pocketed_count"] + 2}
        },
    ),
    "loses energy late": (
        "time until 50% of the energy is left [s]",
        lambda run: {
            "metrics": run.metrics | {"energy_time_50": 1.2 * run.metrics["energy_time_50"]}
        },
    ),
    "leaves the balls half a metre off": (
        REST_POSITIONS,
        lambda run: {"rest_positions": run.rest_positions + np.array([0.5, 0.0, 0.0])},
    ),
}


@pytest.mark.parametrize(("quantity", "fault"), FAULTS.values(), ids=FAULTS.keys())
def test_a_fault_is_seen_in_its_own_quantity(
    quantity: str, fault: Callable[[Any], Any], reference: list[Any]
) -> None:
    wrong = [SimpleNamespace(**vars(run) | fault(run)) for run in reference]
    assert different(wrong, reference) == {quantity}


def test_the_same_runs_are_not_different(reference: list[Any]) -> None:
    found = compare_samples(reference, reference)
    assert [q.name for q in found] == [*QUANTITIES, REST_POSITIONS]
    assert all(q.p == 1.0 and q.by == 0.0 for q in found)


def test_a_difference_of_the_stated_size_is_seen_and_a_tenth_of_it_is_not(
    reference: list[Any],
) -> None:
    found = {q.name: q for q in compare_samples(reference, reference)}
    size = found["rest time [s]"].visible
    assert size is not None
    for part, seen in ((1.3, True), (0.1, False)):
        late = [
            SimpleNamespace(**vars(run) | {"rest_time": run.rest_time + part * size})
            for run in reference
        ]
        assert ("rest time [s]" in different(late, reference)) is seen


def test_holm_adjusts_as_published() -> None:
    # By hand: 3 * 0.01 = 0.03; 2 * 0.02 = 0.04, which is more; and 0.5.
    assert holm([0.02, 0.5, 0.01]) == pytest.approx([0.04, 0.5, 0.03])
    assert holm([0.4, 0.6]) == pytest.approx([0.8, 0.8])


def test_the_energy_distance_is_that_of_its_definition() -> None:
    random = np.random.default_rng(3)
    one, other = random.normal(size=(4, 2, 2)), random.normal(size=(5, 2, 2))

    def mean(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.mean([[np.linalg.norm(x - y, axis=1).mean() for y in b] for x in a]))

    together = np.concatenate([one, other])
    distances = _mean_distances(together, together)
    expected = 2.0 * mean(one, other) - mean(one, one) - mean(other, other)
    assert _energy_distance(distances, 4) == pytest.approx(expected)
    permuted = _permuted(distances, 4, 7, np.random.default_rng(5))
    chosen = np.random.default_rng(5).permuted(np.tile(np.arange(9), (7, 1)), axis=1)[:, :4]
    for value, rows in zip(permuted, chosen, strict=True):
        order = [*rows, *sorted({*range(9)} - {*rows})]
        assert value == pytest.approx(_energy_distance(distances[np.ix_(order, order)], 4))


def verdict(*quantities: QuantityVerdict, ended: int = 40, exact: bool = True) -> EnsembleVerdict:
    return EnsembleVerdict(
        "shot", "pymunk", ended, ended, ended, 0, (), exact, 0.1, tuple(quantities)
    )


def test_the_verdicts_in_words() -> None:
    late = QuantityVerdict("rest time [s]", 2.5, 0.1, 2.0, 0.5, 1e-5, 0.2)
    same = QuantityVerdict("pocketed balls", 1.0, 0.1, 1.0, 0.0, 1.0, 0.4)
    words = ensemble_words(verdict(late, same))
    assert words == "different from the reference with p < 0.001 in rest time, by +0.5 s"
    assert verdict(late, same).failed
    assert not verdict(late, same, exact=False).failed
    assert "doesn't claim to be exact" in ensemble_words(verdict(late, exact=False))
    words = ensemble_words(verdict(same))
    assert words == (
        "not distinguishable with 40 runs; smallest visible difference: pocketed balls 0.4"
    )
    few = verdict(same, same, ended=3)
    assert few.is_blind
    assert f"{runs_needed(2)} or more can" in ensemble_words(few)


def test_members_are_cases_and_the_scenes_stay_as_they_are(tmp_path: Path) -> None:
    outcome = run_suite(
        select(["stop"]), ["ghostball", "paper-discrete"], tmp_path, ensemble=Ensemble(6)
    )
    assert (outcome.exit_status, len(outcome.cases)) == (ExitStatus.PASSED, 14)
    results = Results.open(tmp_path)
    assert results.scene_names == ["stop"]
    assert [case.scene for case in results.cases] == ["stop", "stop"]
    assert (len(results.varied), results.planned) == (12, 14)
    for case in results.varied:
        assert case.varied_from == "stop"
        assert case.accuracy is None
        assert results.motion(case) is None
        assert {check.metric for check in case.checks} <= {"energy_rise", "overlap_max"}
        assert case.left_out == ()
        assert set(MEMBER_METRICS) <= set(case.metrics)
    ours, stepped = ensemble_verdicts(results)
    assert (ours.label, ours.planned, ours.ended, ours.broken) == ("ghostball", 6, 6, 0)
    assert (ours.exact, stepped.exact) == (True, False)
    # The spread of one ball, computed by hand.
    rest = np.array([c.rest_positions[0] for c in results.varied if c.label == "ghostball"])
    assert ours.position_spread == pytest.approx(math.sqrt(rest.var(axis=0).sum()))
    times = [c.rest_time for c in results.varied if c.label == "ghostball"]
    assert ours.quantities == ()
    found = {q.name: q for q in stepped.quantities}
    assert found["rest time [s]"].known == pytest.approx(np.mean(times))
    assert stepped.is_blind  # six runs are too few


def test_members_are_reused_and_more_begin_with_those_of_fewer(tmp_path: Path) -> None:
    engines, scenes = ["paper-discrete"], select(["stop"])
    run_suite(scenes, engines, tmp_path, ensemble=Ensemble(3), reuse=True)
    again = run_suite(scenes, engines, tmp_path, ensemble=Ensemble(4), reuse=True)
    assert again.counts.reused == 4
    alone = run_suite(scenes, engines, tmp_path, reuse=True)
    assert len(alone.cases) == 1
    assert Results.open(tmp_path).varied == []


def test_an_engine_that_breaks_the_law_from_a_perturbed_state_fails(tmp_path: Path) -> None:
    """Fails if the limits for all shots aren't applied to perturbed states."""
    outcome = run_suite(
        [find_scene("half-ball-cut")],
        ["wrong_engines:Wrong:way=energy"],
        tmp_path,
        ensemble=Ensemble(2),
    )
    assert outcome.exit_status is ExitStatus.CHECK_FAILED
    (found,) = ensemble_verdicts(Results.open(tmp_path))
    assert (found.ended, found.broken) == (2, 2)
    assert found.quantities == ()  # Ghostball's engine did not run


@pytest.fixture
def validate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., CliResult]:
    monkeypatch.setenv("COLUMNS", "250")

    def run(*words: object) -> CliResult:
        asked = ["validate", "stop", "-o", tmp_path / "out", "-j", 1, *words]
        return CliRunner().invoke(app, [str(one) for one in asked])

    return run


@pytest.mark.usefixtures("without_run_figures", "in_this_process")
def test_the_command_prints_and_reports_the_verdicts(
    tmp_path: Path, validate: Callable[..., CliResult]
) -> None:
    engines = ("-e", "ghostball", "-e", "paper-discrete")
    found = validate(*engines, "--ensemble", 20, "--ensemble-size", "velocity=1e-4")
    assert found.exit_code == 0, found.output  # the engine's time step explains the difference
    for part in ("20 of 20", "velocity=0.0001,position=0.0001", "different from the reference"):
        assert part in found.stdout
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert "different from the reference with p &lt; 0.001 in rest time" in page
    for wrong, said in (
        (["--ensemble", 1], "at least 2 members"),
        (["--ensemble-size", "velocity=0.01"], "needs --ensemble K"),
        (["--ensemble", 2, "--ensemble-size", "velocity=1"], "must be less than or equal to 0.1"),
    ):
        refused = validate(*engines, *wrong)
        assert refused.exit_code == 2
        assert said in " ".join(refused.output.split())


@pytest.mark.usefixtures("without_run_figures", "in_this_process")
def test_an_engine_that_claims_to_be_exact_and_differs_fails(
    validate: Callable[..., CliResult],
) -> None:
    """The engine of the reference also runs, although no option names it."""
    engine = ("-e", "wrong_engines:Wrong:way=late-rest", "--no-report")
    found = validate(*engine, "--ensemble", 12, "--metric", "rest_error_max")
    assert found.exit_code == 1, found.output
    assert "different from the reference with p < 0.001 in rest time, by +0.5 s" in found.stdout


def test_a_size_that_is_too_large_for_a_scene_is_refused_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop: Callable[..., None] = pytest.fail
    monkeypatch.setattr("ghostball.validation.suite.suite.run", stop)
    with pytest.raises(EnsembleError, match="balls could change places"):
        run_suite(
            select(["stop"]),
            ["ghostball"],
            tmp_path,
            ensemble=Ensemble(2, PerturbationSize(velocity=1e-3, position=0.01)),
        )
