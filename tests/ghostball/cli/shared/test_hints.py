"""Hints after the verdicts of a run, for an engine that applies restitution twice."""

from __future__ import annotations

import inspect
import re
import sys

import pytest
from commands import cli

from ghostball.validation.examples import first_engine


@pytest.fixture
def twice(tmp_path, monkeypatch, in_this_process):
    """An engine whose only mistake is that it squares the restitution of balls."""
    right = inspect.getsource(first_engine)
    wrong = right.replace("restitution = 1.0", "restitution = physics.ball_restitution**2")
    assert wrong != right
    (tmp_path / "twice.py").write_text(wrong, "utf-8")
    monkeypatch.chdir(tmp_path)
    yield "twice:simulate"
    sys.modules.pop("twice", None)


def validate(*arguments):
    return cli("validate", *arguments, "--no-report")


def test_a_run_that_never_tried_it_says_so(twice):
    found = validate("head-on", "draw-shot", "-e", twice)
    assert found.exit_code == 0, found.output
    assert "0 failed" in found.stdout
    assert "twice:simulate claims features that no scene tested:" in found.stdout
    text = " ".join(found.stdout.split())
    assert "ball-ball restitution below 1" in text
    scenes = "cloth-frictionless restitution-head-on unbounded-cut wall-bounce"
    assert f"test with `ghostball validate {scenes} -e twice:simulate`" in text
    assert "doesn't support 1 of these scenes (–). Missing: sliding" in found.stdout


WIDE_BUT_FOR_ONE = """
from dataclasses import replace

from ghostball import Feature, simulate
from ghostball.reference_adapters import EngineBase
from ghostball.model.features import EXACT


class Wide(EngineBase):
    name = "wide"
    capabilities = dict.fromkeys(Feature, EXACT)

    def resolution(self, scene):
        return 0.0 if scene.name == "stop" else 1.0

    def simulate(self, scene, *, record="rest"):
        return replace(simulate(scene, record=record), engine="wide", settings={})
"""


def test_a_run_says_in_how_many_scenes_it_judged_the_end(tmp_path, monkeypatch, in_this_process):
    (tmp_path / "wide.py").write_text(WIDE_BUT_FOR_ONE, "utf-8")
    monkeypatch.chdir(tmp_path)
    found = validate("head-on", "stop", "half-ball-cut", "-e", "wide:Wide")
    assert found.exit_code == 0, found.output
    assert "wide:Wide: the final positions were judged in 1 of 3 scenes" in found.stdout
    assert "the end of the shot" not in validate("stop", "-e", "wide:Wide").stdout
    sys.modules.pop("wide", None)


def test_supported_features_that_no_scene_tested_are_listed(tmp_path, monkeypatch, in_this_process):
    # Each scene with this ball law also has a cushion, friction between balls, or a loss.
    lines = inspect.getsource(first_engine).splitlines(keepends=True)
    start, end = lines.index("@plays(\n"), lines.index(")\n")
    claims = "@plays(Feature.SLIDING, Feature.UNBOUNDED_CLOTH, Feature.MATHAVAN_BALL)\n"
    (tmp_path / "narrow.py").write_text("".join([*lines[:start], claims, *lines[end + 1 :]]))
    monkeypatch.chdir(tmp_path)
    found = validate("draw-shot", "-e", "narrow:simulate")
    sys.modules.pop("narrow", None)
    assert "no shipped scene that it supports tests this" in " ".join(found.stdout.split())


def test_after_a_failure_the_next_command_is_named(twice):
    found = validate("stop", "restitution-head-on", "restitution-cut", "-e", twice)
    assert found.exit_code == 1, found.output
    text = " ".join(found.stdout.split())
    assert "all 2 have ball collisions; no other scene does" in text
    assert "next: `ghostball explain restitution-cut --engine twice:simulate`" in text


def test_where_an_engine_raised_is_named(twice, tmp_path):
    (tmp_path / "raises.py").write_text(
        "def simulate(scene):\n    return scene.nonsense\n", "utf-8"
    )
    found = validate("stop", "-e", "raises:simulate")
    sys.modules.pop("raises", None)
    assert found.exit_code == 1
    assert "(raises.py:2)" in found.stdout
    assert "next: `ghostball run stop --engine raises:simulate`" in found.stdout


def test_the_largest_error_that_passed_is_explained_with_a_command(in_this_process):
    # The first verdict on an engine must not consist only of ticks.
    engine = f"{first_engine.__name__}:simulate"
    found = validate("stop", "half-ball-cut", "-e", engine)
    assert found.exit_code == 0, found.output
    text = " ".join(found.stdout.split())
    assert re.search(
        r"the largest error that a limit allowed is 3\.\d+ mm in half-ball-cut, within the limit "
        r"of \d\.\d+ mm\. Contacts are detected up to one time step, 1 ms, late, which moves the "
        r"rest positions of this shot by at most \d\.\d+ mm; "
        r"the motion between contacts adds \d+ µm\.",
        text,
    )
    assert f"next: `ghostball explain half-ball-cut --engine {engine}`" in text


def test_after_a_failure_the_largest_passed_error_names_no_next_command(twice):
    found = validate("stop", "half-ball-cut", "restitution-head-on", "-e", twice)
    text = " ".join(found.stdout.split())
    assert "the largest error that a limit allowed" in text
    assert text.count("next: ") == 1
