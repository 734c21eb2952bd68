"""A small run with its page, and Chromium to open it.

Where there is no Chromium these tests are skipped, unless GHOSTBALL_BROWSER_TESTS=required: CI sets
it, since a test that nobody runs finds nothing. All of them are slow: `make test-slow` runs them.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from replay_run import small_run

from ghostball.reports import write_report
from ghostball.validation.results.store import Results

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = [
    "--no-sandbox",  # CI runs as root, in a container
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark every test of this folder as slow; pytest calls this hook only for this folder."""
    item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results folder of the small run."""
    return small_run(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="session")
def results(run_folder: Path) -> Results:
    """The stored results of the page."""
    return Results.open(run_folder)


@pytest.fixture(scope="session")
def page_url(run_folder: Path) -> str:
    """Address of the page, written without figures."""
    return write_report(run_folder, figures="none").as_uri()


@pytest.fixture(scope="session")
def chromium() -> str:
    """Path of the browser."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is not None:
        return found
    advice = (
        f"no browser: none of {', '.join(BROWSERS)} is on the PATH. "
        "Debian, Ubuntu: apt-get install chromium"
    )
    if os.environ.get("GHOSTBALL_BROWSER_TESTS") == "required":
        pytest.fail(advice)
    pytest.skip(advice)


@pytest.fixture(scope="module")
def browser(chromium: str):
    """Chromium without a window, for one module: its event loop must end with the module."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        instance = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield instance
        instance.close()


@dataclass
class Opened:
    """A tab, with its console messages and requests."""

    page: object
    said: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


@pytest.fixture
def open_page(browser, page_url: str) -> Iterator[Callable[..., object]]:
    """Open the page at a scene; fail at the end after console messages or other requests."""
    opened: list[Opened] = []
    with ExitStack() as stack:

        def go(scene: str | None = None, **options: object):
            context = stack.enter_context(browser.new_context(**options))
            one = Opened(context.new_page())
            opened.append(one)
            one.page.on("console", lambda message: one.said.append(message.text))
            one.page.on("pageerror", lambda error: one.said.append(str(error)))
            one.page.on("request", lambda request: one.requests.append(request.url))
            one.page.goto(page_url if scene is None else f"{page_url}#scene={scene}")
            if scene is not None:
                # The replay is mounted when it comes into view, and then reads its data.
                element = one.page.locator(f"[data-replay='replay-{scene}']")
                element.evaluate(
                    """async (element) => {
                        while (!element.ghostball) await new Promise(requestAnimationFrame);
                        await element.ghostball.ready;
                    }"""
                )
            return one.page

        yield go
        for one in opened:
            assert one.said == []
            assert [url for url in one.requests if url.split("#")[0] != page_url] == []
