"""Task files, marker sets and norms with nasty values: what they say, or our own error."""

import warnings
from dataclasses import replace

import pytest

from plantigrade.errors import FileError, ParameterError, PlantigradeError
from plantigrade.toml import MAX_BYTES, parse_toml, read_toml
from plantigrade.trajopt import ContactBody, make_task, read_task_file
from plantigrade.trajopt.tasks.settings import settings_for
from tests.nasty import seeds
from tests.nasty.judge import findings
from tests.nasty.targets import marker_set, person, task_file

pytestmark = pytest.mark.wrong_types

HUMAN = person()


@pytest.mark.parametrize(
    "name", ["task: squat", "task: walk", "marker set", "norms", "figures", "kept results"]
)
def test_mutants(tmp_path, name):
    """Numbers, words and lines in turn are others, missing or twice."""
    assert findings(name, tmp_path, 300) == []


def test_endless_times_of_a_stance_are_compared_without_a_warning(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(seeds.SQUAT.replace("heel_strike = -1.0", "heel_strike = inf"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(PlantigradeError, match="out of order"):
            task_file(path)


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
@pytest.mark.parametrize("read", [task_file, marker_set])
def test_invalid_toml_is_reported(tmp_path, read, value, match):
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
    path.write_bytes(b"#" * (MAX_BYTES + 1))
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
    ("task", "options", "rate"),
    [("walk", {"steps": 200, "speed": 0.3}, 500.0), ("standing", {"duration": 60.0}, 500.0)],
)
def test_a_mesh_no_machine_has_memory_for_is_refused(task, options, rate):
    """Each number is within its bounds, all of them together are not."""
    made = replace(make_task(task, HUMAN, options), nodes_per_second=rate)
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
