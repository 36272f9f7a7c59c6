"""Make the moving picture of the README and of the first page: a walk, a push, and a foot in X-ray.

It needs a Chromium and Pillow: ``python docs/make_front.py`` from the checkout. The commands of
``COMMANDS`` make the run; the picture is what its viewer page draws.
"""

import base64
import contextlib
import io
import shlex
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from plantigrade.commands.main import main as plantigrade  # noqa: E402
from tests.browser import Browser  # noqa: E402

IMAGE = Path(__file__).resolve().parent / "images" / "front.gif"
COMMANDS = """
plantigrade synthesize walk --periodic --feet multi-segment --out runs/walk
plantigrade simulate runs/walk --push 120,0.2,90,2 --duration 6 --out runs/pushed
"""
START, STOP = 1.5, 3.95  # [s] from a step before the push until the walk goes on as before
RATE = 10.0  # [1/s] frames of the picture: GIF counts hundredths of a second
SPEED = 0.7  # of the picture: a push of 0.2 s can be seen
BODY, FOOT = (390, 380), (260, 380)  # [px] side by side; chosen
VIVID = 55  # [of 255] saturation above which a colour belongs to the person or an arrow
COLOURS = 64  # of the palette: fewer are seen as bands on the floor
CAMERA = {
    BODY: "plantigrade.setView('front'); camera.azimuth += 0.75; camera.elevation = 0.14;"
    "camera.distance = 3.5; plantigrade.show.ref = false;",
    FOOT: "plantigrade.setView('foot'); camera.distance = 1.15;",  # in X-ray
}


def draw(page: Path) -> list[Image.Image]:
    """Return the frames: person on the left, right foot on the right."""
    count = round((STOP - START) / SPEED * RATE)
    with Browser(width=500, height=420) as browser:
        browser.open(page, ready="document.body.dataset.ready")
        browser.evaluate("plantigrade.pause(); window.requestAnimationFrame = () => 0; 0")
        panels = []
        for size in (BODY, FOOT):
            browser.evaluate(f"{CAMERA[size]} 0")
            panels.append([panel(browser, START + k * SPEED / RATE, size) for k in range(count)])
    return [beside(*pair) for pair in zip(*panels, strict=True)]


def panel(browser: Browser, time: float, size: tuple[int, int]) -> Image.Image:
    """Return what the viewer draws at a time [s] in a size [px]."""
    width, height = size
    address = browser.evaluate(
        f"(() => {{ plantigrade.seek({time}); draw({{ width: {width}, height: {height} }});"
        "return canvas.toDataURL('image/png'); })()"
    )
    return Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2]))).convert("RGB")


def beside(body: Image.Image, foot: Image.Image) -> Image.Image:
    """Return two panels in one picture."""
    both = Image.new("RGB", (BODY[0] + FOOT[0] + 4, BODY[1]), "white")
    both.paste(body, (0, 0))
    both.paste(foot, (BODY[0] + 4, 0))
    return both


def palette_of(frames: list[Image.Image]) -> Image.Image:
    """Return a palette in which few vivid pixels count as much as the many grey ones of the floor.

    Pixels are sorted by saturation (greatest less least channel); the push is the most vivid.
    """
    pixels = np.concatenate([np.asarray(frame).reshape(-1, 3) for frame in frames]).astype(int)
    saturation = pixels.max(axis=1) - pixels.min(axis=1)
    red, green, blue = pixels.T
    groups = (saturation <= VIVID, saturation > VIVID, (red > green + 80) & (blue > green + 40))
    rng = np.random.default_rng(0)
    drawn = [
        pixels[rng.choice(np.flatnonzero(group), count)]
        for group, count in zip(groups, (48_000, 48_000, 4_000), strict=True)
    ]
    square = np.concatenate(drawn).astype(np.uint8).reshape(250, 400, 3)
    return Image.fromarray(square).quantize(COLOURS)


def main() -> None:
    """Write ``docs/images/front.gif``."""
    if len(sys.argv) > 1:
        frames = draw(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            for line in COMMANDS.strip().splitlines():
                plantigrade([*shlex.split(line)[1:], "--quiet"])
            frames = draw(Path("runs/pushed/viewer.html"))
    palette = palette_of(frames[::4])
    few = [each.quantize(palette=palette, dither=Image.Dither.NONE) for each in frames]
    few[0].save(
        IMAGE, save_all=True, append_images=few[1:], duration=round(1000 / RATE), loop=0,
        optimize=True,
    )  # fmt: skip
    print(f"{IMAGE}: {len(few)} frames, {IMAGE.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
