"""The page on motion from a task runs as printed, and what it says of the motions is true."""

import re
from pathlib import Path

import numpy as np
import pytest

from plantigrade import check
from tests.paste import blocks, commands, run_code

pytestmark = pytest.mark.solver

PAGE = Path(__file__).resolve().parents[1] / "docs" / "synthesize.md"
TEXT = PAGE.read_text("utf-8")


@pytest.fixture(scope="module")
def page():
    """Every name the page defines, after all its code has run from top to bottom."""
    return run_code(PAGE)


def test_the_squat_passes_the_check(page):
    assert page["squat"].success and page["verdict"].status == "ok"


def test_in_ski_boots_the_trunk_leans_further(page):
    squat, boots, largest, lean = (page[n] for n in ("squat", "in_boots", "largest", "lean"))
    assert boots.success
    assert largest(boots, "ankle_angle_r") < 10.5 < largest(squat, "ankle_angle_r") - 10.0
    assert lean(boots) > lean(squat) + 20.0
    verdict = check(boots.record())
    assert verdict.ok, verdict.words()


def test_hips_go_down_to_the_requested_depth(page):
    squat = page["squat"]
    height = squat.sample(squat.times()).qpos[:, 2]
    assert height[0] - height.min() == pytest.approx(0.3, abs=0.01)


def test_the_task_file_shifts_the_weight(page):
    from plantigrade.trajopt import parse_task_file, synthesize

    (text,) = blocks(PAGE, "toml")
    task_file = parse_task_file(text)
    task = task_file.task(page["human"])
    made = synthesize(page["body"], page["replace"](task, nodes_per_second=10.0))
    verdict = check(made.record())
    assert verdict.conditions and verdict.ok, verdict.words()
    middle = verdict.com[np.argmin(np.abs(made.times() - 1.0))]
    assert middle[1] == pytest.approx(-0.06, abs=1e-3)


def test_its_commands_and_options_exist(tmp_path, monkeypatch):
    from plantigrade.commands.main import parse

    monkeypatch.chdir(tmp_path)
    (text,) = blocks(PAGE, "toml")
    (tmp_path / "shift.toml").write_text(text)
    every = list(commands(PAGE, "bash"))
    assert len(every) > 5
    for words in every:
        assert words[0] == "plantigrade"
        parse(words[1], words[2:])


def test_its_pictures_and_links_are_there():
    for target in re.findall(r"\]\(([\w./-]+)\)", TEXT):
        assert (PAGE.parent / target).is_file(), target
