"""Base and head of a scene in a browser: two motions on one clock, or rest positions alone."""

import json

import numpy as np
import pytest

from ghostball.reports.page.replay_assets import replay_script, replay_style
from ghostball.reports.page.replay_data import motion_data, scene_data
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


def settled_pictures(page):
    """Return the pictures once they stay as they are: a late change of the layout draws anew."""
    now = pictures(page)
    for _ in range(50):
        before, now = now, pictures(page)
        if now == before:
            return now
    raise AssertionError("the pictures go on changing")


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


def test_equal_sides_differ_by_nothing(mounted, both):
    page = mounted({"base": both["base"], "head": both["base"]})
    assert "No ball differs by more than 20 µm here." in page.get_by_role("status").inner_text()


def test_the_wipe_changes_the_third_picture_alone(mounted, both):
    page = mounted(both)
    before = pictures(page)
    assert len(before) == 3
    page.get_by_role("slider", name="Wipe").fill("1")
    after = pictures(page)
    assert after[:2] == before[:2]
    assert after[2] != before[2]


def test_one_view_for_all_three(mounted, both):
    page = mounted(both)
    before = settled_pictures(page)
    page.get_by_role("button", name="Closer").nth(1).click()
    assert all(one != other for one, other in zip(before, pictures(page), strict=True))
    page.get_by_role("button", name="Whole table").first.click()
    assert settled_pictures(page) == before
    page.get_by_role("button", name="Look at the largest difference").click()
    assert pictures(page) != before


def test_rest_positions_alone(mounted, shot, motions):
    rests = {label: motions[label].positions[-1].tolist() for label in (BASE, HEAD)}
    given = {"scene": scene_data(shot), "rest_base": rests[BASE], "rest_head": rests[HEAD]}
    page = mounted(given)
    assert places(page, "base") == [place[:2] for place in rests[BASE]]
    assert places(page, "head") == [place[:2] for place in rests[HEAD]]
    assert page.get_by_role("button", name="Play").count() == 0
    json.dumps(given, allow_nan=False)


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
