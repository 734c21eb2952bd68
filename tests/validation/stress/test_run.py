"""A stress run: what is asked for, what stands from earlier runs, and what a fault costs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import ghostball.validation.stress.run
from ghostball.model import EngineFailedError, GhostballError, SceneError, UnsupportedSceneError
from ghostball.validation.results.database import transaction, writing
from ghostball.validation.stress import StressOutcome, run_stress
from ghostball.validation.stress.families import chosen_trials
from ghostball.validation.stress.findings import Finding, StressFolder, StressRun
from ghostball.validation.stress.run import StressTask, run_trial
from ghostball.validation.stress.trial import CRASHED, Trial

ONE = ["grazing/rolling-hit-1e-01"]
TWO = [*ONE, "grazing/rolling-miss-1e-01"]


@pytest.mark.parametrize(
    ("labels", "options", "message"),
    [
        ([], {}, "at least one engine"),
        (["ghostball", "ghostball"], {}, "once, got ghostball again"),
        (["no-such-engine"], {}, "no-such-engine"),
        (["pymunk:dt=fast"], {}, "dt"),
        (["ghostball"], {"jobs": 0}, "`jobs` must be at least 1"),
        (["ghostball"], {"time_limit": float("nan")}, "`time_limit` must be a positive number"),
        (["ghostball"], {"only": ["grasing"]}, "'grasing'. Families: "),
        (["ghostball"], {"only": ["grazing/*-9e-99"]}, "'grazing/*-9e-99'"),
    ],
)
def test_what_is_wrong_is_refused_before_anything_is_written(tmp_path, labels, options, message):
    with pytest.raises(GhostballError) as caught:
        run_stress(labels, tmp_path / "out", **options)
    assert message in str(caught.value)
    assert not (tmp_path / "out").exists()


def in_database(folder, statement):
    with writing(folder) as database, transaction(database):
        database.execute(statement)


def made_by_other_code(folder):
    in_database(folder, "UPDATE documents SET content = json_set(content, '$.code_hash', 'other')")
    in_database(folder, "UPDATE records SET code = 'other'")


@pytest.fixture
def here(monkeypatch):
    """Run trials in this process: what is kept of a run doesn't ask who made it."""
    monkeypatch.setattr("ghostball.validation.parallel.pool.limit_of", lambda _: None)


@pytest.mark.usefixtures("here")
def test_a_run_is_kept_and_reused_by_the_same_code_alone(tmp_path):
    first = run_stress(["ghostball"], tmp_path, only=TWO)
    assert first.exit_status == 0
    assert (first.reused, len(first.folder.findings)) == (0, 2)
    again = run_stress(["ghostball"], tmp_path, only=TWO)
    assert again.reused == 2
    in_database(tmp_path, "DELETE FROM records WHERE id = (SELECT max(id) FROM records)")
    assert run_stress(["ghostball"], tmp_path, only=TWO).reused == 1
    made_by_other_code(tmp_path)
    assert run_stress(["ghostball"], tmp_path, only=TWO).reused == 0
    assert len(StressFolder.load(tmp_path).findings) == 2


@pytest.mark.usefixtures("here")
def test_a_look_at_a_part_does_not_make_a_run_whole(tmp_path):
    # Breaks where what is planned is counted from what is asked last, or from what is there.
    def interrupt(*_):
        raise KeyboardInterrupt

    outcome = run_stress(["ghostball", "pymunk"], tmp_path, only=TWO, progress=interrupt)
    assert (outcome.interrupted, outcome.exit_status) == (True, 130)
    folder = StressFolder.load(tmp_path)
    assert (folder.planned, len(folder.findings), folder.whole) == (4, 1, False)
    part = run_stress(["ghostball"], tmp_path, only=ONE)
    assert (part.folder.planned, part.folder.whole) == (4, False)
    assert StressFolder.load(tmp_path).missing == part.folder.missing
    more = run_stress(["ghostball"], tmp_path, only=["grazing/sliding-hit-1e-01"])
    assert (more.folder.planned, more.folder.whole) == (5, False)
    assert more.folder.run.labels == ("ghostball", "pymunk")
    rest = run_stress(["ghostball", "pymunk"], tmp_path, only=TWO)
    assert (rest.folder.planned, len(rest.folder.findings), rest.folder.whole) == (5, 5, True)


@pytest.mark.usefixtures("here")
def test_what_other_code_was_asked_for_is_no_part_of_a_run(tmp_path):
    run_stress(["ghostball"], tmp_path, only=TWO)
    made_by_other_code(tmp_path)
    outcome = run_stress(["pymunk"], tmp_path, only=ONE)
    assert (outcome.folder.planned, outcome.folder.run.labels) == (1, ("pymunk",))


GUEST = """
from dataclasses import replace
from ghostball.reference_adapters.paper.discrete import PaperDiscreteEngine
class E(PaperDiscreteEngine):
    name = "guest"
    def simulate(self, scene, *, record="rest"):
        return replace(super().simulate(scene, record=record), engine=self.name)
"""


@pytest.mark.usefixtures("here")
def test_what_another_version_of_an_engine_did_is_no_part_of_a_run(tmp_path, monkeypatch):
    # It stood beside what the version that is here now did.
    module, guest = tmp_path / "stress_guest.py", "stress_guest:E"
    monkeypatch.syspath_prepend(str(tmp_path))

    def tried(text, one):
        module.write_text(text)
        monkeypatch.delitem(sys.modules, "stress_guest", raising=False)
        outcome = run_stress(["paper-discrete", guest], tmp_path / "out", only=[one])
        found = outcome.folder.findings
        return {label: sum(each.label == label for each in found) for label in outcome.must_hold}

    assert tried(GUEST, TWO[0]) == {"paper-discrete": 1, guest: 1}
    assert tried(GUEST, TWO[1]) == {"paper-discrete": 2, guest: 2}
    assert tried(GUEST + "# edited", TWO[0]) == {"paper-discrete": 2, guest: 1}


@pytest.mark.usefixtures("here")
def test_a_crash_is_tried_again_where_it_is_asked_for_and_else_stays(tmp_path, monkeypatch):
    crashed = Finding("grazing", "rolling-hit-1e-01", "pymunk", "broken", ("crashed",), CRASHED)
    with monkeypatch.context() as patch:
        patch.setattr(ghostball.validation.stress.run, "run_trial", lambda _: crashed)
        run_stress(["pymunk"], tmp_path, only=ONE)
    run_stress(["ghostball"], tmp_path, only=ONE)
    assert {one.outcome for one in StressFolder.load(tmp_path).findings} == {"survived", "broken"}
    assert run_stress(["pymunk"], tmp_path, only=ONE).reused == 0


class Planted(Trial):
    """A trial that raises."""

    name = "planted"

    def __init__(self, error):
        self.error = error

    def run(self, engine):
        raise self.error


@pytest.mark.parametrize(
    ("error", "outcome"),
    [
        (GhostballError("nothing is proved"), "failed"),
        (SceneError("a scene of the trial's own"), "failed"),
        (EngineFailedError("pymunk", "SceneError: the engine's"), "broken"),
        (RuntimeError("lost the balls"), "broken"),
        (SystemExit(0), "broken"),
        (UnsupportedSceneError("pymunk", ("no spin",)), "not-representable"),
    ],
)
def test_who_is_to_blame_for_an_error(error, outcome):
    found = run_trial(StressTask("f", Planted(error), "pymunk"))
    assert found.outcome == outcome


def outcome_of(*findings, must_hold=()):
    run = StressRun("quick", ("f",), (), {})
    there = StressFolder(Path("nowhere"), run, list(findings))
    return StressOutcome(there, tuple(one.key for one in findings), must_hold)


@pytest.mark.parametrize(
    ("outcomes", "status"),
    [
        ({"ghostball": "survived", "pymunk": "broken"}, 0),
        ({"ghostball": "broken", "pymunk": "survived"}, 1),
        ({"ghostball": "survived", "mine": "broken"}, 1),
        ({"mine": "survived", "pymunk": "broken"}, 0),
        ({"pymunk": "not-representable", "pybullet": "unavailable"}, 4),
        ({"ghostball": "survived", "mine": "not-judged"}, 4),
        ({"ghostball": "survived", "pymunk": "not-judged"}, 0),
        ({"ghostball": "broken", "mine": "not-judged"}, 1),
        ({"ghostball": "broken", "pymunk": "failed"}, 3),
    ],
)
def test_what_must_hold_decides_the_status_and_the_others_are_shown(outcomes, status):
    found = [Finding("f", "a", label, outcome) for label, outcome in outcomes.items()]
    assert outcome_of(*found, must_hold=("ghostball", "mine")).exit_status == status


def test_a_limit_of_time_only_shortens_that_of_a_trial(tmp_path, monkeypatch):
    seen = []

    def asked(limit):
        ((family, trial),) = chosen_trials("quick", ONE)
        seen.append(limit(StressTask(family.name, trial, "pymunk")))

    monkeypatch.setattr("ghostball.validation.parallel.pool.limit_of", asked)
    for seconds in (None, 1.0, 1e6):
        run_stress(["pymunk"], tmp_path / str(seconds), only=ONE, time_limit=seconds)
    assert seen == [60.0, 1.0, 60.0]


def test_our_engine_may_not_refuse_a_scene(tmp_path, monkeypatch):
    class Refused(Trial):
        name = "refused"

        def run(self, engine):
            raise UnsupportedSceneError(engine.name, ("no such law",))

    ours = run_trial(StressTask("any", Refused(), "ghostball"))
    assert (ours.outcome, ours.broken) == ("broken", 1)
    assert "no such law" in ours.faults[0]
    other = run_trial(StressTask("any", Refused(), "paper-discrete"))
    assert (other.outcome, other.faults) == ("not-representable", ("no such law",))


def test_a_changed_criterion_is_another_code(tmp_path, monkeypatch):
    """What trials play besides the code: shipped scenes and their criteria."""
    monkeypatch.setattr(ghostball.validation.stress.run, "FOLDER", tmp_path)
    monkeypatch.setattr(ghostball.validation.stress.run, "code_hash", lambda: "abc")
    hashes = [ghostball.validation.stress.run._hash_of_all()]
    (tmp_path / "common.expect.toml").write_text("limit = 32")
    hashes.append(ghostball.validation.stress.run._hash_of_all())
    (tmp_path / "common.expect.toml").write_text("limit = 64")
    hashes.append(ghostball.validation.stress.run._hash_of_all())
    assert len(set(hashes)) == 3
    monkeypatch.setattr(ghostball.validation.stress.run, "code_hash", lambda: "")
    assert ghostball.validation.stress.run._hash_of_all() == ""
