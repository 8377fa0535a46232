"""A run's playback in a browser that nobody sees."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from scenarios.format.errors import ScenarioError

if TYPE_CHECKING:
    from playwright.sync_api import Page

_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
_ARGUMENTS = (
    "--no-sandbox",  # containers offer it no namespaces
    "--use-angle=swiftshader",  # WebGL without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
)
_READY = "() => typeof viewer !== 'undefined' && viewer.animator && viewer.animator.duration > 0"
_DRAWN = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
MENDS = "pip install 'contact-toolkit[video]', and Chromium (Debian: apt install chromium)"


class PlaybackPage:
    """An open `playback.html`."""

    def __init__(self, page: Page) -> None:
        self._page = page

    @property
    def duration(self) -> float:
        """Length of the animation [s]."""
        return float(self._page.evaluate("viewer.animator.duration"))

    def picture(self, time: float) -> bytes:
        """Return what is seen at a time [s], as PNG."""
        self._page.evaluate(
            f"viewer.animator.pause(); viewer.animator.seek({time}); viewer.needs_render = true;"
        )
        self._page.evaluate(_DRAWN)
        return self._page.locator("canvas").first.screenshot()


@contextmanager
def playback_page(playback: Path, size: tuple[int, int]) -> Iterator[PlaybackPage]:
    """Open a playback in a window of that size [px]; ScenarioError where there is no browser."""
    browser_path = next((found for name in _BROWSERS if (found := shutil.which(name))), None)
    try:
        from playwright.sync_api import sync_playwright
    except ImportError as error:
        raise ScenarioError(f"pictures need a browser: {MENDS}") from error
    if browser_path is None:
        raise ScenarioError(f"pictures need a browser: {MENDS}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=list(_ARGUMENTS))
        try:
            page = browser.new_page(viewport={"width": size[0], "height": size[1]})
            page.goto(playback.resolve().as_uri())
            page.wait_for_function(_READY)
            page.evaluate("viewer.set_property(['Background'], 'visible', false)")
            page.add_style_tag(content=".dg { display: none; }")
            yield PlaybackPage(page)
        finally:
            browser.close()
