"""Draw the pictures of README and documentation: walks, a reach, a squat."""

import contextlib
import io
import re
from pathlib import Path

from plantigrade.models import Human
from plantigrade.report.strip import instants, strip_svg
from plantigrade.workflows.textbook import textbook_walk

HERE = Path(__file__).parent
BACKGROUND = "#f6f7f9"


def main() -> None:
    """Write ``docs/images/*.svg``."""
    (HERE / "images").mkdir(exist_ok=True)
    walk()
    ordered_tasks()
    synthesized()


def walk() -> None:
    """Draw the picture at the head of the README: the textbook walk on multi-segment feet."""
    walk = textbook_walk(Human.create(feet="multi-segment"), speed=1.3, cycles=2)
    stride = [e.time for e in walk.events if e.side == "r" and e.kind == "heel_strike"]
    start, stop = (int(round(100 * t)) for t in stride[:2])
    frames = [start + round((stop - start) * k / 8) for k in range(9)]
    draw("walk", walk.human.model, walk.qpos, frames)


def ordered_tasks() -> None:
    """Draw the movements of the page on ordered tasks, made by the code printed there."""
    page = (HERE / "ordered-tasks.md").read_text("utf-8")
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()):
        for block in re.findall(r"^```python\n(.*?)^```", page, re.M | re.S):
            exec(compile(block, "ordered-tasks.md", "exec"), names)
    for name, motion in (("reach", names["motion"]), ("squat", names["squat"])):
        draw(name, names["human"].model, motion.qpos, instants(len(motion.qpos), 7))


def synthesized() -> None:
    """Draw a stride of a walk that was made from the task alone."""
    from plantigrade.synthesize.tasks.settings import Walk
    from plantigrade.workflows.settings import SolveSettings
    from plantigrade.workflows.synthesize import synthesize_task

    told, how = Walk(periodic=True, strides=1), SolveSettings(feet="multi-segment")
    run = synthesize_task(told, how)
    if not run.ok:
        raise SystemExit(run.status)
    motion = run.record.motion
    draw("synthesized", run.record.human.model, motion.qpos, instants(motion.n_frames, 9))


def draw(name: str, model, qpos, frames) -> None:
    """Write one picture."""
    svg = strip_svg(model, qpos, frames, height_px=260, background=BACKGROUND)
    (HERE / "images" / f"{name}.svg").write_text(svg, encoding="utf-8")


if __name__ == "__main__":
    main()
