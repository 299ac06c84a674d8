"""`make gallery`: runs the commands of docs/gallery.md and keeps what they make, small, in docs/gallery.

The page is the only list of the commands. What they write goes to out/gallery, which is emptied first.
"""

import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

ROOT = Path(__file__).parents[1]
PAGE, KEPT = ROOT / "docs" / "gallery.md", ROOT / "docs" / "gallery"
MADE = ROOT / "out" / "gallery"
FILES = {"methods.mp4": 1_500_000, "report.html": 2_500_000}  # kept as they are; bytes at most
MOST_BYTES = 100_000  # of a picture
WIDTH = 1280  # px, of a picture at most
_QUALITY = 80  # of WebP
_BLOCK = re.compile(r"^```text\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_SCREEN = 1280, 800  # px, of pictures of the report

Image = NDArray[np.uint8]


def commands() -> list[list[str]]:
    """The commands of the page in its order, word by word."""
    text = "\n".join(_BLOCK.findall(PAGE.read_text(encoding="utf-8")))
    return [shlex.split(line) for line in text.replace("\\\n", " ").splitlines() if line]


def drawn(name: str) -> Image:
    """A picture that a command has written."""
    image = cv2.imread(str(MADE / name))
    if image is None:
        raise FileNotFoundError(f"expected a picture in {MADE / name}")
    return np.asarray(image, dtype=np.uint8)


def rendered(style: str) -> Image:
    """The three pictures of a dataset, beside each other."""
    return np.concatenate([drawn(f"{style}/test/000000/rgb/{number:06}.png") for number in range(3)], axis=1)


def frame(video: str, second: float) -> Image:
    """A video's first frame from a time on (s of the video)."""
    with av.open(MADE / video) as container:
        shown = next(one for one in container.decode(video=0) if one.time is not None and one.time >= second)
        return np.asarray(shown.to_ndarray(format="bgr24"), dtype=np.uint8)


def newest_look(video: str) -> Image:
    """The panel of the newest look, in a video's first frame: the right-hand third below the wrist camera's picture."""
    image = frame(video, 0)
    height, width, _ = image.shape
    overview = width // 2  # px high; see experiments/video/tile.py
    return image[height - overview // 2 :, 4 * overview // 3 + 2 :]


def screenshot(address: str) -> Image:
    """What Chromium shows of the report at an address in it."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    width, height = _SCREEN
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars"):
        options.add_argument(argument)
    browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get((MADE / "report.html").as_uri() + address)
        png = np.frombuffer(browser.get_screenshot_as_png(), dtype=np.uint8)
    finally:
        browser.quit()
    return np.asarray(cv2.imdecode(png, cv2.IMREAD_COLOR), dtype=np.uint8)


PICTURES: dict[str, Callable[[], Image]] = {
    "cell": partial(drawn, "cell.png"),
    "handle": partial(drawn, "handle.png"),
    "wrist": partial(drawn, "wrist.png"),
    "look": partial(newest_look, "look.mp4"),
    "wrong": partial(drawn, "uq/worst.png"),
    "right": partial(drawn, "uq/best.png"),
    "methods": partial(frame, "methods.mp4", 7.7),
    "report": partial(screenshot, ""),
    "attempt": partial(screenshot, "#handle/ensemble-add/1/4"),
    "part": partial(drawn, "bracket/preview.png"),
    "s1": partial(rendered, "s1"),
    "s2": partial(rendered, "s2"),
}


def main() -> None:
    """Runs the commands, then keeps the pictures, the video and the report.

    Raises:
        CalledProcessError: a command fails.
        ValueError: something is larger than a page should load.
    """
    shutil.rmtree(MADE, ignore_errors=True)
    MADE.mkdir(parents=True)
    for name, *arguments in commands():
        module = [] if name == "python" else ["-m", "experiments.cli"]
        subprocess.run([sys.executable, *module, *arguments], cwd=ROOT, check=True)
    shutil.rmtree(KEPT, ignore_errors=True)
    KEPT.mkdir()
    for name, make in PICTURES.items():
        _keep(f"{name}.webp", _small(make()), MOST_BYTES)
    for name, most in FILES.items():
        _keep(name, (MADE / name).read_bytes(), most)


def _small(image: Image) -> bytes:
    """The picture as WebP, at most `WIDTH` wide."""
    height, width, _ = image.shape
    if width > WIDTH:
        image = np.asarray(cv2.resize(image, (WIDTH, round(height * WIDTH / width)), interpolation=cv2.INTER_AREA))
    _, encoded = cv2.imencode(".webp", image, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
    return encoded.tobytes()


def _keep(name: str, content: bytes, most: int) -> None:
    if len(content) > most:
        raise ValueError(f"expected at most {most:,} bytes for {name}, got {len(content):,}")
    (KEPT / name).write_bytes(content)


if __name__ == "__main__":
    main()
