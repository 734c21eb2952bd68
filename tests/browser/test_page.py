"""The report's page in a browser: layout, links to scenes, and no requests for other files."""

import pytest
from replay_run import HOSTILE

CUT, DRAW = "half-ball-cut", "draw-shot"
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}

# `open_page` fails a test if the page writes to the console, or requests another file.


@pytest.mark.parametrize("scene", [None, CUT])
@pytest.mark.parametrize("size", [{}, PHONE])
def test_the_whole_page_fits_the_screen(open_page, size, scene):
    page = open_page(scene, **size)
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        wide = page.evaluate(
            """() => [...document.querySelectorAll("main *, nav *")].filter((one) => {
                const box = one.getBoundingClientRect();
                const scrolls = (up) => up && (getComputedStyle(up).overflowX !== "visible"
                    || scrolls(up.parentElement));
                return box.width && box.right > innerWidth + 1 && !scrolls(one.parentElement);
            }).map((one) => `${one.tagName}.${one.className}`)"""
        )
        assert wide == []
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_link_opens_its_scene_and_steps_continue(open_page, results):
    page = open_page(DRAW)
    assert page.locator(f"#scene\\={DRAW}").is_visible()
    page.evaluate("name => { location.hash = `#scene=${name}`; }", CUT)
    page.locator(f"#scene\\={CUT}").wait_for(state="visible")
    assert page.locator(f"#scene\\={DRAW}").is_hidden()


def viewed(page, t):
    """Return which engines the replay shows, once it is at an instant."""
    view = f"document.querySelector(\"[data-replay='replay-{CUT}']\").ghostball?.view"
    page.wait_for_function(f"{view}?.t === {t}")
    return page.evaluate(f"{view}.engines")


def test_a_link_opens_a_scene_at_an_instant_with_its_engines(open_page):
    page = open_page()
    page.evaluate(f"location.hash = '#scene={CUT}&t=0.25&engine=paper-discrete'")
    assert viewed(page, 0.25) == ["paper-discrete"]


def test_a_copied_link_restores_the_view(open_page):
    page = open_page(CUT)
    replay = page.locator(f"[data-replay='replay-{CUT}']")
    replay.evaluate("one => one.ghostball.look({t: 0.125, engines: ['ghostball']})")
    page.locator(".scene.open").get_by_role("button", name="Copy a link").click()
    link = page.evaluate("location.hash")
    assert link == f"#scene={CUT}&t=0.125&engine=ghostball"
    page.evaluate("location.hash = '#scene=draw-shot'")
    page.evaluate("link => { location.hash = link; }", link)
    assert viewed(page, 0.125) == ["ghostball"]


def test_a_cell_leads_to_its_engine_beside_ours(open_page):
    page = open_page()
    cell = f".matrix a[href*='scene={CUT}&'][href$='engine=paper-discrete']"
    page.locator(cell).first.click()
    assert viewed(page, 0) == ["ghostball", "paper-discrete"]


def test_tables_sort_by_accuracy_by_run_time_and_by_name(open_page):
    page = open_page()

    def column(table, k):
        cells = page.locator(f"{table} tbody tr > :nth-child({k})")
        return cells.evaluate_all("found => found.map(one => one.dataset.value)")

    def press(table, k):
        page.locator(f"{table} thead th:nth-child({k}) button").click()

    engines, matrix = "table.engines", "#matrix table"
    for k in (2, 3, 4):
        press(engines, k)
        sizes = [float(one or "inf") for one in column(engines, k)]
        assert sizes == sorted(sizes)
    press(matrix, 3)
    sizes = [float(one or "inf") for one in column(matrix, 3)]
    assert sizes == sorted(sizes)
    assert len(set(sizes)) > 2
    press(matrix, 1)
    names = page.locator(f"{matrix} tbody th").all_inner_texts()
    assert names == sorted(names)


def test_names_of_scenes_never_run_as_scripts(open_page):
    page = open_page("hostile")
    assert page.evaluate("typeof pwned") == "undefined"
    assert HOSTILE in page.locator("#scene\\=hostile").inner_text()
    replay = page.locator("[data-replay='replay-hostile']")
    assert replay.locator("img").count() == 0
    assert "<img" in replay.locator(".gb-log").inner_text()


def test_without_scripts_every_scene_is_there_to_read(open_page, results):
    page = open_page(java_script_enabled=False)
    for name in results.scene_names:
        heading = page.get_by_role("heading", name=name, exact=True)
        assert heading.first.is_visible()


def test_after_a_click_on_a_cell_the_keys_of_the_replay_work(open_page):
    # Without the focus in the scene, Space would scroll the page.
    page = open_page()
    page.locator(f".matrix a[href*='scene={CUT}&'][href$='engine=paper-discrete']").first.click()
    viewed(page, 0)
    replay = f"document.querySelector(\"[data-replay='replay-{CUT}']\").ghostball"
    page.keyboard.press("n")
    first = page.evaluate(f"{replay}.time")
    assert first > 0.0
    page.keyboard.press("n")
    assert page.evaluate(f"{replay}.time") > first
    page.keyboard.press("Home")
    before = page.evaluate("scrollY")
    page.keyboard.press("Space")
    assert page.evaluate(f"{replay}.playing")
    assert page.evaluate("scrollY") == before
    page.keyboard.press("Space")
    assert not page.evaluate(f"{replay}.playing")


@pytest.mark.parametrize("size", [{}, PHONE])
def test_captions_can_be_read_whole_and_no_label_of_an_axis_is_cut(open_page, size):
    page = open_page(CUT, **size)
    cut = page.evaluate(
        """() => {
            const found = [];
            for (const caption of document.querySelectorAll(".wide caption, .gb-scroll caption")) {
                const box = caption.getBoundingClientRect();
                const around = caption.closest(".wide, .gb-scroll").getBoundingClientRect();
                if (box.width && box.right > around.right + 1) found.push(caption.textContent);
            }
            for (const text of document.querySelectorAll("svg.chart text:not(.marker)")) {
                const box = text.getBoundingClientRect();
                const around = text.closest("svg").getBoundingClientRect();
                if (box.width && (box.left < around.left - 1 || box.right > around.right + 1
                    || box.top < around.top - 1 || box.bottom > around.bottom + 1))
                    found.push(text.textContent);
            }
            return found;
        }"""
    )
    assert cut == []


def test_a_table_of_few_scenes_has_no_rows_to_scroll(open_page):
    page = open_page()
    for box in page.locator("#matrix .wide").all():
        assert box.evaluate("one => one.scrollHeight <= one.clientHeight")


def test_the_three_comparisons_stand_side_by_side_where_there_is_room(open_page):
    page = open_page(viewport={"width": 1280, "height": 900})
    tops = page.locator("#comparison figure").evaluate_all(
        "found => found.map(one => Math.round(one.getBoundingClientRect().top))"
    )
    assert len(tops) == 3
    assert len(set(tops)) == 1
