"""Make every picture of the documentation anew: run the commands that the gallery prints.

The two movements on the page on ordered tasks come from the code printed there.
"""

import contextlib
import io
import re
import shlex
import shutil
import sys
import tempfile
from pathlib import Path

from plantigrade.commands.main import main as plantigrade

HERE = Path(__file__).resolve().parent
IMAGES = HERE / "images"


def main() -> None:
    """Write ``docs/images/*.svg``, all or those whose names are given."""
    chosen = set(sys.argv[1:])
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        gallery(chosen)
        ordered_tasks(chosen)
        for picture in Path().glob("*.svg"):
            shutil.copyfile(picture, IMAGES / picture.name)


def gallery(chosen: set[str]) -> None:
    """Run the commands of the gallery, block by block."""
    page = (HERE / "gallery.md").read_text("utf-8")
    for block in re.findall(r"^```bash\n(.*?)^```", page, re.M | re.S):
        lines = [shlex.split(line) for line in block.splitlines()]
        if not chosen or Path(lines[-1][-1]).stem in chosen:
            for words in lines:
                run(words[1:])


def ordered_tasks(chosen: set[str]) -> None:
    """Draw the movements of the page on ordered tasks."""
    if chosen and not chosen & {"reach", "squat"}:
        return
    from plantigrade.motion import Motion
    from plantigrade.record import Record, Run

    page = (HERE / "ordered-tasks.md").read_text("utf-8")
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()):
        for block in re.findall(r"^```python\n(.*?)^```", page, re.M | re.S):
            exec(compile(block, "ordered-tasks.md", "exec"), names)
    human = names["human"]
    for name, moved in (("reach", names["motion"]), ("squat", names["squat"])):
        motion = Motion(moved.time, moved.qpos, moved.qvel, human.joint_names)
        Run(Record(human, motion), "fit", title=name.title()).save(f"runs/{name}")
        run(["picture", f"runs/{name}", "--rate", "15", "--foot", "none", "--out", f"{name}.svg"])


def run(words: list[str]) -> None:
    """Run a command; end where it fails."""
    print("plantigrade", *words, flush=True)
    if code := plantigrade([*words, "--quiet"]):
        sys.exit(f"exit code {code}: {' '.join(words)}")


if __name__ == "__main__":
    main()
