"""The files of the page on tasks of your own are tasks, and some are solved."""

from functools import cache
from pathlib import Path

import pytest

from plantigrade import check
from plantigrade.models import Human
from plantigrade.trajopt import TaskFile, parse_task_file, synthesize
from plantigrade.workflows.settings import SolveSettings
from tests.paste import blocks

PAGE = Path(__file__).resolve().parents[1] / "docs" / "own-tasks.md"
FILES: dict[str, TaskFile] = {f.name: f for f in map(parse_task_file, blocks(PAGE, "toml"))}


@cache
def person() -> Human:
    return Human.create(1.72, 68.0, joints="42", feet="two-segment")


def task_of(name: str):
    """Return the person and the task of a file."""
    file = FILES[name]
    impaired = SolveSettings(**file.options)
    human = impaired.person(person())
    return human, impaired.task(human, file.task(human))


def test_there_are_as_many_as_it_says():
    assert len(FILES) == 19


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_a_task_of_a_person(name):
    human, task = task_of(name)
    body = task.body_of(human)
    assert task.name == name
    for term in task.terms:
        term.conditions(body, task.plan)


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize(
    "name",
    [
        "tug of a rope",
        "rise onto the toes",
        "squat with an upright trunk",
        "lean on a wall",
        "hand on a sliding rail",
        "sit on a seat that rises",
        "stand in a braking bus",
        "stand up from half-kneeling",
    ],
)
def test_a_file_is_solved(name):
    human, task = task_of(name)
    made = synthesize(task.body_of(human), task)
    verdict = check(made.record())
    assert made.success and verdict.ok, verdict.words()
