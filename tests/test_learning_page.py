"""The page on learning to walk runs as printed, and its numbers are those of the environment."""

import re
from pathlib import Path

import pytest

from tests.paste import blocks, run_code

PAGE = Path(__file__).resolve().parents[1] / "docs" / "learning.md"
TEXT = PAGE.read_text("utf-8")


@pytest.mark.slow
def test_the_page_runs_and_says_how_many_numbers_there_are():
    from plantigrade.learn import WalkEnv

    assert len(blocks(PAGE, "python")) == 1
    reference = run_code(PAGE)["env"].unwrapped.tracking.reference
    row = next(line for line in TEXT.splitlines() if line.startswith("| size of observation"))
    paper, lean = (WalkEnv(reference, form=form) for form in ("paper", "lean"))
    sizes = [*paper.observation_space.shape, *paper.action_space.shape]
    sizes += [*lean.observation_space.shape, *lean.action_space.shape]
    sizes += WalkEnv(reference, gains=True).action_space.shape
    assert re.findall(r"\d+", row) == [str(n) for n in sizes]
