"""Task files and marker sets with nasty values: a task or a set, or our own error."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import FileError, ParameterError, PlantigradeError
from plantigrade.models import Human
from plantigrade.models.markers import place_markers, read_marker_set
from plantigrade.synthesize import ContactBody, make_task, read_task_file
from plantigrade.synthesize.tasks.settings import settings_for
from plantigrade.toml import LIMIT, parse_toml, read_toml
from tests import nasty

pytestmark = pytest.mark.wrong_types

HUMAN = Human.create(height=1.7, mass=65.0)
TASKS = {
    "squat": """
[task]
name = "deep squat"
base = "squat"
without = ["acceleration"]
nodes_per_second = 20
basis = "polynomial"
[parameters]
depth = 0.4
duration = 2.5
[[term]]
type = "within"
coordinate = "knee_angle_r"
low_deg = 0.0
high_deg = 10.0
[[term]]
type = "reach"
point = { body = "hand_r", position = [0.0, 0.0, -0.1], radius = 0.0 }
target = [0.4, nan, 1.0]
time = 1.0
[[term]]
type = "limits"
ranges = { knee_angle = [0.0, 2.0] }
[[stance]]
side = "r"
x = 0.0
heel_strike = -1.0
toe_off = 100.0
heading_deg = 3
[[stance]]
side = "l"
""",
    "walk": """
[task]
base = "walk"
[parameters]
speed = 1.0
steps = 3
heights = [0.0, 0.1, 0.0]
turn_deg = 0
""",
}
SET = """
name = "my lab"
[markers]
RKN1 = "knee_lateral_r"
RTH7 = { body = "femur_r", position = [0.05, -0.09, -0.2] }
"""


def read_task(path):
    read_task_file(path).task(HUMAN)


def place_set(path):
    own = read_marker_set(path)
    place_markers([*own.landmarks, *own.fixed], HUMAN, own)


@pytest.mark.parametrize(
    ("text", "read"),
    [(TASKS["squat"], read_task), (TASKS["walk"], read_task), (SET, place_set)],
    ids=["squat", "walk", "markers"],
)
def test_nasty_values(tmp_path, text, read):
    path = tmp_path / "own.toml"
    path.write_text(text)
    read(path)  # else nothing below says anything
    for what, content in nasty.texts(text, 500):
        path.write_bytes(content)
        with warnings.catch_warnings(), np.errstate(over="ignore"):  # of a step of 1e-308 m
            warnings.simplefilter("error")
            try:
                read(path)
            except PlantigradeError as error:
                assert len(str(error)) < 2000, what
            except Exception as error:
                raise AssertionError(what) from error


@pytest.mark.parametrize(
    ("value", "match"),
    [
        ("9" * 5000, "4300 digits"),
        ("1" + "0" * 400, "too many digits"),
        ("[" * 100_000, "nested too deeply"),
        ("[" * 40 + "]" * 40, "nested too deeply"),
        ("1\nx = 1", "overwrite"),
    ],
    ids=["5000 digits", "400 digits", "deep", "deep and closed", "twice"],
)
@pytest.mark.parametrize("read", [read_task, place_set])
def test_what_is_no_toml_is_said(tmp_path, read, value, match):
    path = tmp_path / "own.toml"
    path.write_text(f"[task]\nname = 'a'\n[markers]\nx = {value}\n")
    with pytest.raises(FileError, match=match) as caught:
        read(path)
    assert "own.toml" in str(caught.value)


def test_files_that_are_no_small_text(tmp_path):
    path = tmp_path / "own.toml"
    path.write_bytes(b"a = 1 # \xff")
    with pytest.raises(FileError, match="is not a TOML file"):
        read_toml(path)
    path.write_bytes(b"#" * (LIMIT + 1))
    with pytest.raises(FileError, match="larger than 1 MiB"):
        read_toml(path)
    with pytest.raises(FileError, match="cannot be read"):
        read_toml(tmp_path)
    with pytest.raises(FileError, match="null byte"):
        read_toml(str(tmp_path / "a\0b"))
    assert parse_toml("a = -9223372036854775808", path) == {"a": -(2**63)}


@pytest.mark.parametrize(
    ("key", "value"),
    [("speed", 10**400), ("turn", 10**400), ("steps", 10**5000), ("heights", ("x", "y", "z"))],
    ids=["speed", "turn", "steps", "heights"],
)
def test_values_of_settings_that_numpy_cannot_hold(key, value):
    with pytest.raises(PlantigradeError, match="height|speed|turn|steps"):
        settings_for("walk", **{key: value})


@pytest.mark.parametrize(
    ("task", "told", "rate"),
    [("walk", {"steps": 200, "speed": 0.3}, 500.0), ("standing", {"duration": 60.0}, 500.0)],
)
def test_a_mesh_no_machine_has_memory_for_is_refused(task, told, rate):
    """Each number is within its bounds, all of them together are not."""
    made = replace(make_task(task, HUMAN, told), nodes_per_second=rate)
    with pytest.raises(ParameterError, match=r"takes \d+ nodes of about 1 MB; allowed are 5000"):
        made.nodes()
    assert len(replace(made, nodes_per_second=5.0).nodes()) < 5000


@pytest.mark.parametrize(
    "text", ['[[term]]\ntype = "head-stability"\nturning = 0.1', 'without = ["head-stability"]']
)
def test_a_renamed_term_ends_in_its_new_name(text, tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(f'[task]\nbase = "walk"\n{text}\n')
    with pytest.raises(FileError, match="head-stability is now upright") as caught:
        read_task_file(path)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("term", "cost"),
    [
        ('type = "facing"\nweight = inf', "coordinates"),
        ('type = "endurance"\nweight = -3.0', "endurance"),
        ('type = "jerk"\nweight = -1.0', "jerk"),
        ('type = "work"\nweight = inf', "work rate"),
    ],
)
def test_a_cost_without_a_least_value_is_refused(term, cost, tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(f'[task]\nbase = "squat"\n[[term]]\n{term}\n')
    task = read_task_file(path).task(HUMAN)
    with pytest.raises(ParameterError, match=f"cost of {cost} must be finite, zero or more"):
        task.problem(ContactBody.for_plan(HUMAN, task.plan), task.nodes())
