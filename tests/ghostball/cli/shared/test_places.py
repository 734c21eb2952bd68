"""Where in a project's files its engines are, and what its baselines say."""

from __future__ import annotations

import sys

import pytest

from ghostball.cli.shared.places import places_in
from ghostball.reports.ci.findings import Place
from ghostball.validation.examples.stepper import Stepper

ENGINE = """\
from ghostball.validation.examples.stepper import Stepper


class Mine(Stepper):
    name = "mine"
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    (tmp_path / "engine_of_a_project.py").write_text(ENGINE, "utf-8")
    (tmp_path / "kept/mine").mkdir(parents=True)
    (tmp_path / "kept/mine/stop.json").write_text('{\n"a": 1,\n"bits": "0"\n}', "utf-8")
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path))
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    sys.modules.pop("engine_of_a_project", None)


def test_an_engine_is_where_its_class_begins(project):
    engine = places_in(project / "kept").engine
    assert engine("engine_of_a_project:Mine:dt=1e-3", "") == Place("engine_of_a_project.py", 4)
    # Neither is in the project, or is at all.
    assert engine(f"{Stepper.__module__}:Stepper", "") is None
    assert engine("engine_of_a_project:None", "") is None
    assert engine("ghostball", "") is None


def test_a_failure_is_at_the_innermost_line_of_the_project(project):
    engine = places_in(project / "kept").engine
    trace = "\n".join(
        f'  File "{name}", line {line}, in x\n    y()'
        for name, line in (
            (project / "engine_of_a_project.py", 9),
            (project / "deep/part.py", 12),
            (project / "venv/site-packages/numpy/x.py", 3),
            ("/usr/lib/python3/json.py", 5),
        )
    )
    assert engine("engine_of_a_project:Mine", trace) == Place("deep/part.py", 12)


def test_a_baseline_is_at_the_line_that_says_it(project):
    baseline = places_in(project / "kept").baseline
    assert baseline("mine", "stop", "bits") == Place("kept/mine/stop.json", 3)
    assert baseline("mine", "stop", "nothing") == Place("kept/mine/stop.json", 1)
    assert baseline("mine", "lost", "bits") == Place("kept/mine/lost.json", 1)
    assert places_in(project.parent / "elsewhere").baseline("mine", "stop", "bits") is None
