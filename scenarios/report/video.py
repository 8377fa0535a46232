"""Make a video of a run's playback, in a browser that nobody sees."""

from __future__ import annotations

import io
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

from scenarios.format.errors import ScenarioError
from scenarios.report.playback_page import MENDS, playback_page


def check_video(path: Path) -> None:
    """Raise ScenarioError for a file that no video can be written to, by its name."""
    if path.suffix not in (".mp4", ".gif"):
        raise ScenarioError(f"{path}: a video ends in .mp4 or .gif")


def make_video(
    folder: Path, path: Path, *, frame_rate: float = 25.0, size: tuple[int, int] = (960, 640)
) -> Path:
    """Film `playback.html` of a run folder into an .mp4 or .gif file and return its path.

    Raises ScenarioError for another suffix and where what films it is missing.
    """
    check_video(path)
    frames = _frames(folder / "playback.html", frame_rate, size)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".gif":
        first, *rest = (Image.open(io.BytesIO(frame)).convert("P") for frame in frames)
        first.save(path, save_all=True, append_images=rest, duration=1000 / frame_rate, loop=0)
        return path
    command = [
        _ffmpeg(), "-y", "-loglevel", "error", "-f", "image2pipe", "-framerate", str(frame_rate),
        "-i", "-", "-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", str(path),
    ]  # fmt: skip
    with subprocess.Popen(command, stdin=subprocess.PIPE) as process:  # noqa: S603  our arguments
        assert process.stdin is not None
        for frame in frames:
            process.stdin.write(frame)
        process.stdin.close()
        if process.wait():
            raise ScenarioError(f"{path}: ffmpeg could not write it")
    return path


def _frames(playback: Path, frame_rate: float, size: tuple[int, int]) -> Iterator[bytes]:
    with playback_page(playback, size) as page:
        for number in range(int(page.duration * frame_rate) + 1):
            yield page.picture(number / frame_rate)


def _ffmpeg() -> str:
    if found := shutil.which("ffmpeg"):
        return found
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise ScenarioError(
            f"an .mp4 needs ffmpeg (Debian: apt install ffmpeg), a .gif does not; or {MENDS}"
        ) from error
    return str(imageio_ffmpeg.get_ffmpeg_exe())
