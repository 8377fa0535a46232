"""Pictures of runs: the key frame of each, and all on one sheet."""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib as mpl
from PIL import Image, ImageDraw, ImageFont

from scenarios.format.errors import ScenarioError
from scenarios.format.loading import load
from scenarios.report.playback_page import playback_page
from scenarios.report.summary import Summary

SIZE = (480, 360)  # [px] of a picture
COLUMNS = 5  # of the sheet
SHEET = "contact_sheet.png"
_CAPTION = 26  # [px]


def make_gallery(runs: Path, out: Path) -> list[Path]:
    """Draw the key frame of every run in `runs` into `out`, and the sheet; return their paths.

    The moment is that of `visualization.key_frame`. Raises ScenarioError where there are no runs,
    or no browser.
    """
    folders = sorted(path.parent for path in runs.glob("*/playback.html"))
    if not folders:
        raise ScenarioError(f"{runs}: no run in it has a playback.html; run --all makes them")
    out.mkdir(parents=True, exist_ok=True)
    return [*(_key_frame(folder, out) for folder in folders), contact_sheet(out)]


def contact_sheet(gallery: Path) -> Path:
    """Put the pictures in a folder on one sheet, each under its name, and return its path."""
    pictures = [path for path in sorted(gallery.glob("*.png")) if path.name != SHEET]
    width, height = SIZE[0] // 2, SIZE[1] // 2 + _CAPTION
    rows = -(-len(pictures) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * width, rows * height), "white")
    font = ImageFont.truetype(Path(mpl.get_data_path(), "fonts/ttf/DejaVuSans.ttf"), 14)
    draw = ImageDraw.Draw(sheet)
    for number, path in enumerate(pictures):
        left, top = number % COLUMNS * width, number // COLUMNS * height
        with Image.open(path) as picture:
            small = picture.convert("RGB").resize((width, height - _CAPTION), Image.Resampling.BOX)
        sheet.paste(small, (left, top))
        middle = (left + width // 2, top + height - _CAPTION // 2)
        draw.text(middle, path.stem, fill="black", font=font, anchor="mm")
    return _save(sheet, gallery / SHEET)


def _key_frame(folder: Path, out: Path) -> Path:
    name = Summary.load(folder).scenario
    moment = load(str(folder / "scenario.yaml"))[1].visualization.key_frame
    with playback_page(folder / "playback.html", SIZE) as page:
        picture = page.picture(page.duration if moment is None else min(moment, page.duration))
    return _save(Image.open(io.BytesIO(picture)).convert("RGB"), out / f"{name}.png")


def _save(picture: Image.Image, path: Path) -> Path:
    picture.save(path, optimize=True)
    return path
