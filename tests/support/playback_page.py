"""A playback in headless Chromium: what it complains about and what it shows.

Run as a script it saves one frame, such as the picture in the README:

    python tests/playback_page.py RUN_FOLDER TIME PICTURE.png
"""

import io
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

_ARGUMENTS = (
    "--no-sandbox",  # containers offer it no namespaces
    "--use-angle=swiftshader",  # WebGL without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)
_READY = "() => typeof viewer !== 'undefined' && viewer.animator && viewer.animator.duration > 0"
_DRAWN = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
_WEB = "viewer.scene_tree.find(['drake', 'contact']).object.visible"


class PlaybackPage:
    """An open playback; `complaints` collects console errors and exceptions."""

    def __init__(self, page: Page) -> None:
        self.complaints: list[str] = []
        self._page = page
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on(
            "console",
            lambda message: (
                self.complaints.append(message.text)
                if message.type in {"error", "warning"} and "GPU stall" not in message.text
                else None
            ),
        )

    def open(self, playback: Path, ready: str = _READY) -> None:
        self._page.goto(playback.resolve().as_uri())
        self._page.wait_for_function(ready)

    @property
    def duration(self) -> float:
        """Length of the animation [s]."""
        return float(self._page.evaluate("viewer.animator.duration"))

    def seek(self, time: float) -> None:
        """Stop the animation at a time [s]."""
        self._page.evaluate(f"viewer.animator.pause(); viewer.animator.seek({time});")

    def play(self, wait: float) -> None:
        """Let the animation play from here for `wait` seconds."""
        self._page.evaluate("viewer.animator.play()")
        self._page.wait_for_timeout(1000 * wait)

    def show_web(self, *, visible: bool) -> None:
        """Show or hide the proximity edges, whatever the animation says about each frame's."""
        self._page.evaluate(f"{_WEB} = {str(visible).lower()}")

    def hide_controls(self) -> None:
        """Take away the button that lies over the canvas."""
        self._page.add_style_tag(content=".dg { display: none; }")

    def pixels(self) -> np.ndarray:
        """Return what the canvas shows now, (height, width, 3) bytes."""
        self._page.evaluate("viewer.needs_render = true")
        self._page.evaluate(_DRAWN)
        shot = self._page.locator("canvas").first.screenshot()
        return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"))


@contextmanager
def playback_page(width: int = 640, height: int = 480) -> Iterator[PlaybackPage]:
    """Open a page for playbacks, its canvas width × height pixels."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(_ARGUMENTS))
        try:
            page = browser.new_page(viewport={"width": width, "height": height})
            yield PlaybackPage(page)
        finally:
            browser.close()


if __name__ == "__main__":
    folder, time, picture = sys.argv[1:]
    with playback_page(960, 640) as opened:
        opened.open(Path(folder) / "playback.html")
        opened.hide_controls()
        opened.seek(float(time))
        Image.fromarray(opened.pixels()).save(picture, optimize=True)
