"""The replay in a browser shows the stored data."""

import numpy as np
import pytest
from replay_run import BREAKS_AT, BROKEN, ENGINES

from ghostball.reports.page.replay_tracks import TOLERANCE

CUT, DRAW, CHAIN, JUMP = "half-ball-cut", "draw-shot", "three-ball-chain", "flight-jump"


def replay_of(page, scene=CUT):
    return page.locator(f"[data-replay='replay-{scene}']")


def state(page, scene=CUT, what="time"):
    return replay_of(page, scene).evaluate(f"element => element.ghostball.{what}")


def seek(page, t, scene=CUT):
    replay_of(page, scene).evaluate("(element, t) => element.ghostball.seek(t)", t)


def shown(page, label, scene=CUT):
    return replay_of(page, scene).evaluate(
        "(element, label) => element.ghostball.positions(label)", label
    )


def shown_at(page, label, times, scene):
    """Positions at several times, (k, n, 2) [m], each after a seek."""
    places = replay_of(page, scene).evaluate(
        """(element, [label, times]) => times.map((t) => {
            element.ghostball.seek(t);
            return element.ghostball.positions(label);
        })""",
        [label, times.tolist()],
    )
    return np.array(places)


def interpolated(motion, times, axis):
    """One coordinate of every ball between the stored samples, (k, n) [m]."""
    columns = motion.positions[:, :, axis].T
    return np.column_stack([np.interp(times, motion.times, column) for column in columns])


def picture(page, scene=CUT):
    """Return the picture of the table after the next frame."""
    return replay_of(page, scene).evaluate(
        """element => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(
            () => done(element.querySelector("canvas.gb-canvas").toDataURL()))))"""
    )


def test_nothing_is_decoded_before_a_scene_is_opened(open_page):
    page = open_page()
    assert page.evaluate("Ghostball.decoded") == 0
    page.evaluate("location.hash = '#scene=draw-shot'")
    page.wait_for_function("Ghostball.decoded === 1")


@pytest.mark.parametrize("scene", [CUT, DRAW, JUMP])
def test_shown_positions_are_the_stored_ones(open_page, results, scene):
    # Fails for any error in packing or reading, and if engines are confused.
    page = open_page(scene)
    for label in ENGINES:
        case = results.case(scene, label)
        motion = results.motion(case)
        if motion is None:
            assert shown(page, label, scene) is None
            continue
        stored = motion.times[::7]
        off = shown_at(page, label, stored, scene) - motion.positions[::7]
        assert np.linalg.norm(off, axis=2).max() <= TOLERANCE + 2e-6
        # Between samples, the stored motion is linear and the replay has parabolas.
        times = np.linspace(0.0, motion.times[-1], 97)
        straight = np.dstack([interpolated(motion, times, k) for k in (0, 1)])
        dt = np.max(np.diff(motion.times))
        bend = 0.5 * 0.2 * 9.81 * (dt / 2) ** 2
        off = shown_at(page, label, times, scene)[..., :2] - straight
        assert np.abs(off).max() < TOLERANCE + bend


def test_a_jump_to_an_event_is_to_its_exact_time(open_page, results):
    page = open_page(CUT)
    times = results.motion(results.case(CUT, "ghostball")).events["t"].tolist()
    events = replay_of(page).locator("select.gb-events")
    assert events.locator("option").count() == len(times)
    for i, t in enumerate(times):
        events.select_option(str(i))
        assert state(page) == t
        replay_of(page).get_by_role("status").filter(has_text=f"t = {t:.4f} s").wait_for()


def test_steps_go_from_event_to_event(open_page, results):
    page = open_page(CUT)
    times = results.motion(results.case(CUT, "ghostball")).events["t"].tolist()
    for t in times:
        replay_of(page).get_by_role("button", name="Next event").click()
        assert state(page) == t
    for t in times[-2::-1]:
        replay_of(page).get_by_role("button", name="Previous event").click()
        assert state(page) == t


def test_the_log_of_another_engine_can_be_chosen(open_page, results):
    page = open_page(CUT)
    replay_of(page).locator(".gb-log select").first.select_option(label="pymunk")
    first = results.motion(results.case(CUT, "pymunk")).events["t"][0]
    page.keyboard.press("Escape")
    replay_of(page).locator(".gb-stage").focus()
    page.keyboard.press("n")
    assert state(page) == first


def test_a_jump_to_the_first_divergence(open_page, results):
    case = results.case(CHAIN, "paper-discrete")
    page = open_page(CHAIN)
    button = replay_of(page, CHAIN).get_by_role("button", name="Jump to the first wrong collision")
    assert "paper-discrete" in button.inner_text()
    button.click()
    assert state(page, CHAIN) == case.metrics["first_divergence_time"]
    page.keyboard.press("Home")
    page.keyboard.press("d")
    assert state(page, CHAIN) == case.metrics["first_divergence_time"]


def test_keys(open_page):
    page = open_page(CUT)
    duration = state(page, what="duration")
    replay_of(page).locator(".gb-stage").focus()
    page.keyboard.press("End")
    assert state(page) == duration
    page.keyboard.press("ArrowLeft")
    assert state(page) == pytest.approx(0.99 * duration)
    page.keyboard.press("Shift+ArrowRight")
    assert state(page) == pytest.approx(0.991 * duration)
    page.keyboard.press("Home")
    assert state(page) == 0
    page.keyboard.press("n")
    first = state(page)
    assert first > 0
    page.keyboard.press("n")
    page.keyboard.press("p")
    assert state(page) == first
    speed = replay_of(page).get_by_label("Speed")
    page.keyboard.press("]")
    assert speed.input_value() == "2"
    page.keyboard.press("[")
    page.keyboard.press("[")
    assert speed.input_value() == "0.5"
    page.keyboard.press(" ")
    assert state(page, what="playing")
    replay_of(page).evaluate(
        """(element, t) => new Promise((done) => {
            const look = () => (element.ghostball.time > t ? done() : requestAnimationFrame(look));
            look();
        })""",
        first,
    )
    page.keyboard.press(" ")
    assert not state(page, what="playing")


def test_two_engines_are_shown_at_first_and_more_on_request(open_page):
    page = open_page(CUT)
    seek(page, 1.5)
    boxes = replay_of(page).locator(".gb-readout").get_by_role("checkbox")
    assert boxes.count() == len([*ENGINES, BROKEN])
    assert replay_of(page).locator(".gb-readout input:checked").count() == 2
    assert replay_of(page).get_by_role("checkbox", name="ghostball").is_checked()
    before = picture(page)
    box = replay_of(page).get_by_role("checkbox", name="paper-discrete")
    box.set_checked(not box.is_checked())
    assert picture(page) != before
    box.set_checked(not box.is_checked())
    assert picture(page) == before


def test_the_numbers_below_the_table_belong_to_the_shown_time(open_page):
    page = open_page(CUT)
    said = replay_of(page).get_by_role("status")
    said.filter(has_text="t = 0.0000 s").wait_for()
    replay_of(page).get_by_role("button", name="Play").click()
    said.filter(has_not_text="t = ").wait_for()
    replay_of(page).get_by_role("button", name="Pause").click()
    said.filter(has_text=f"t = {state(page):.4f} s").wait_for()


def test_the_readout_shows_stored_values(open_page, results):
    page = open_page(CUT)
    motion = results.motion(results.case(CUT, "ghostball"))
    k = len(motion.times) // 2
    seek(page, float(motion.times[k]))
    row = replay_of(page).locator(".gb-readout tbody tr").first
    _, off, x, y, *_ = row.locator("th, td").all_inner_texts()
    assert off == "–"
    assert [float(x), float(y)] == pytest.approx(1e3 * motion.positions[k, 0, :2], abs=0.02)


def test_an_engine_that_could_not_run_says_why(open_page, results):
    page = open_page(DRAW)
    reason = results.case(DRAW, "paper-discrete").reason
    row = replay_of(page, DRAW).locator(".gb-readout tr").filter(has_text="paper-discrete")
    assert reason in row.inner_text()
    assert row.get_by_role("checkbox").is_disabled()


def test_a_ball_that_is_lost_is_absent_and_said_so(open_page):
    page = open_page(CUT)
    seek(page, BREAKS_AT - 0.1)
    assert None not in shown(page, BROKEN)
    seek(page, BREAKS_AT + 0.1)
    first, second = shown(page, BROKEN)
    assert first is None
    assert second is not None
    row = replay_of(page).locator(".gb-readout tbody tr").last
    assert "ball cue is lost after 0.5" in row.inner_text()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            "data.engines.forEach((one) => { one.motion = null; })",
            "No engine recorded its motion in this scene, so there is nothing to replay.",
        ),
        (
            "data.schema = 99",
            "This motion can't be replayed: the data have version 99, but this page reads "
            "version 2.",
        ),
        (
            "data.engines[0].motion.tick = 1e-7; data.balls.push(data.balls[0])",
            "This motion can't be replayed: the motion data are truncated.",
        ),
    ],
)
def test_an_invalid_motion_is_reported(open_page, change, words):
    page = open_page()
    said = page.evaluate(
        f"""async () => {{
            const text = document.getElementById("replay-{CUT}").textContent;
            const data = JSON.parse(text);
            {change};
            const element = document.createElement("div");
            document.body.append(element);
            await Ghostball.mountReplay(element, data).ready;
            return element.textContent;
        }}"""
    )
    assert said == words


def redrawn(page):
    """Wait until the requested drawing is finished, in the next frame."""
    page.evaluate(
        """async () => {
            for (let k = 0; k < 2; k++) await new Promise(requestAnimationFrame);
        }"""
    )


def test_dark_and_light_differ_and_change_while_it_is_open(open_page):
    page = open_page(CUT, color_scheme="light")
    light = picture(page)
    page.emulate_media(color_scheme="dark")
    redrawn(page)
    dark = picture(page)
    assert dark != light
    page.emulate_media(color_scheme="light")
    redrawn(page)
    assert picture(page) == light


def test_a_flight_has_a_shadow_and_is_seen_from_the_side(open_page):
    page = open_page(JUMP)
    side = replay_of(page, JUMP).locator("canvas.gb-side")
    assert side.count() == 1
    seek(page, 0.12, JUMP)
    replay_of(page, JUMP).get_by_role("button", name="Zoom to the selected ball").click()
    flying, above = side.screenshot(), picture(page, JUMP)
    assert "flies" in replay_of(page, JUMP).locator(".gb-readout").inner_text()
    replay_of(page, JUMP).get_by_label("Stripes").uncheck()
    assert picture(page, JUMP) != above
    seek(page, 0.2, JUMP)
    picture(page, JUMP)
    assert side.screenshot() != flying
    events = replay_of(page, JUMP).locator(".gb-events").inner_text()
    assert "cue lands" in events
    page.evaluate("location.hash = '#scene=half-ball-cut'")
    page.wait_for_function("Ghostball.decoded === 2")
    assert replay_of(page).locator("canvas.gb-side").count() == 0
