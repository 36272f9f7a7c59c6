"""Draw the picture at the head of the README: the textbook walk on the multi-segment feet."""

from pathlib import Path

from plantigrade.models import Human
from plantigrade.report.strip import strip_svg
from plantigrade.workflows.textbook import textbook_walk


def main() -> None:
    """Write ``docs/images/walk.svg``."""
    walk = textbook_walk(Human.create(feet="multi-segment"), speed=1.3, cycles=2)
    stride = [e.time for e in walk.events if e.side == "r" and e.kind == "heel_strike"]
    start, stop = (int(round(100 * t)) for t in stride[:2])
    frames = [start + round((stop - start) * k / 8) for k in range(9)]
    svg = strip_svg(walk.human.model, walk.qpos, frames, height_px=260, background="#f6f7f9")
    target = Path(__file__).parent / "images" / "walk.svg"
    target.parent.mkdir(exist_ok=True)
    target.write_text(svg, encoding="utf-8")


if __name__ == "__main__":
    main()
