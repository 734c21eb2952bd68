"""Base and head of a scene in a browser: two motions on one clock, or rest positions alone."""

import numpy as np
import pytest

from ghostball.reports.page.replay_assets import replay_script, replay_style
from ghostball.reports.page.replay_data import motion_data
from ghostball.reports.page.replay_tracks import TOLERANCE
from ghostball.reports.shots import load_shot

SCENE = "half-ball-cut"
BASE, HEAD = "ghostball", "paper-discrete"


@pytest.fixture
def mounted(browser, results):
    """Mount a comparison on an empty page; fails at the end if it complained."""
    said = []
    contexts = []

    def mount(given, **options):
        context = browser.new_context(**options)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.set_content(
            f"<!doctype html><title>Compare</title><style>{replay_style()}</style><div id=it></div>"
            f"<script>{replay_script()}</script>"
        )
        page.evaluate(
            "given => Ghostball.mountCompare(document.getElementById('it'), given).ready", given
        )
        return page

    yield mount
    for context in contexts:
        context.close()
    assert said == []


@pytest.fixture
def shot(results):
    return load_shot(results, SCENE)


@pytest.fixture
def motions(shot):
    return {run.label: run.motion for run in shot.runs}


@pytest.fixture
def both(shot, motions):
    """Base and head, as if the one engine had become the other."""
    return {
        "base": motion_data(shot.scene, motions[BASE]),
        "head": motion_data(shot.scene, motions[HEAD]),
    }


def places(page, side):
    return page.evaluate("side => document.getElementById('it').ghostball.positions(side)", side)


def pictures(page):
    return page.evaluate(
        """() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(
            [...document.querySelectorAll("canvas.gb-canvas")].map((one) => one.toDataURL())))))"""
    )


def test_both_sides_are_at_one_time(mounted, both, motions):
    page = mounted(both)
    t = 0.5 * motions[BASE].times[-1]
    page.evaluate("t => document.getElementById('it').ghostball.seek(t)", t)
    for side, label in (("base", BASE), ("head", HEAD)):
        motion = motions[label]
        k = int(np.searchsorted(motion.times, t))
        step = np.abs(np.diff(motion.positions[k - 1 : k + 1], axis=0)).max()
        off = np.abs(np.array(places(page, side)) - motion.positions[k]).max()
        assert off <= step + TOLERANCE


def test_it_begins_at_the_end_and_says_what_differs_most(mounted, both, motions):
    page = mounted(both)
    ends = [motions[label].positions[-1, :, :2] for label in (BASE, HEAD)]
    largest = 1e3 * np.hypot(*(ends[0] - ends[1]).T).max()
    text = page.get_by_role("status").inner_text()
    assert text.startswith("Largest difference: ball object, ")
    assert float(text.split()[-2]) == pytest.approx(largest, abs=0.1)


def test_while_it_plays_it_says_what_differs_now(mounted, both):
    page = mounted(both)
    said = page.get_by_role("status")
    page.get_by_role("slider", name="Time of both sides").fill("0")
    assert "No ball differs by more than" in said.inner_text()
    page.get_by_role("button", name="Play").click()
    said.filter(has_text="Largest difference: ball").wait_for()
    assert said.get_attribute("aria-live") == "off"
    page.get_by_role("button", name="Pause").click()
    assert said.get_attribute("aria-live") == "polite"
    assert page.locator(".gb-stage button").count() == 0


def test_the_wipe_changes_the_third_picture_alone(mounted, both):
    page = mounted(both)
    before = pictures(page)
    assert len(before) == 3
    page.get_by_role("slider", name="Wipe").fill("1")
    after = pictures(page)
    assert after[:2] == before[:2]
    assert after[2] != before[2]


def test_a_side_without_a_motion_is_refused_in_words(mounted, shot, both):
    silent = [engine | {"motion": None} for engine in both["head"]["engines"]]
    page = mounted({"base": both["base"], "head": both["head"] | {"engines": silent}})
    said = page.locator("#it").inner_text()
    assert said == "Base and head can't be shown: head has no recorded motion."


def test_a_phone_has_them_below_each_other(mounted, both):
    page = mounted(both, viewport={"width": 390, "height": 844})
    tops = page.evaluate(
        "[...document.querySelectorAll('figure')].map((one) => one.getBoundingClientRect().top)"
    )
    assert tops == sorted(set(tops))
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
