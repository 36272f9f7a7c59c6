"""The command for experiments: one by name, all of them, and what differs between two results."""

import inspect
import json
import re

import pytest

from experiments import command as experiment
from experiments.command import EXPERIMENTS, OPTIONS, Command
from experiments.registry import Experiment
from experiments.specification import Specification
from experiments.table import ResultTable, Row, at_most
from plantigrade.commands import main
from plantigrade.errors import ParameterError, RunExists

CALLS = []
FUNCTIONS = {}


def fake(name, value=1.0, error=None):
    """Return a function in place of the ``run`` of an experiment."""

    def run(**options):
        CALLS.append((name, options))
        if error is not None:
            raise error
        rows = [at_most(name, "error", value, 2.0, "mm"), Row(name, "time", value, "s")]
        return ResultTable(name, rows)

    return run


@pytest.fixture
def fakes(monkeypatch, tmp_path):
    """Put fakes in place of every experiment and every command; return their calls."""
    CALLS.clear()
    FUNCTIONS.update({name: fake(name) for name in EXPERIMENTS})
    monkeypatch.setattr(Experiment, "function", lambda self: FUNCTIONS[self.name])
    monkeypatch.setattr(experiment, "COMMANDS", {})
    monkeypatch.setenv("PLANTIGRADE_DATA", str(tmp_path))
    return CALLS


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_each_experiment_takes_what_the_list_says(name):
    parameters = dict(inspect.signature(EXPERIMENTS[name].function()).parameters)
    if parameters.pop("options", None):  # passed on to the specification
        parameters |= inspect.signature(Specification.run).parameters
        del parameters["self"]
    assert {"quick", "say"} <= set(parameters)
    e = EXPERIMENTS[name]
    assert set(e.options) == set(parameters) & set(OPTIONS)
    required = {p for p, v in parameters.items() if v.default is inspect.Parameter.empty}
    assert required == set(e.needs)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_each_experiment_has_a_short_form(name, fakes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    outcome = Command(name=name, quick=True, quiet=True).run()
    ((_, options),) = fakes
    assert options["quick"] and outcome.metrics["goals_met"] == 1
    assert ("data" in options) == ("data" in EXPERIMENTS[name].options)


def test_one_experiment_gets_what_was_given(fakes, tmp_path):
    out = tmp_path / "there"
    how = {"out": out, "parts": ("walk", "warm"), "overwrite": True, "quiet": True}
    Command(name="synthesis-bench", **how).run()
    ((_, options),) = fakes
    assert options["out"] == out and options["parts"] == ("walk", "warm")
    assert options["overwrite"] and not options["quick"]


def test_all_are_run_and_one_that_fails_does_not_end_them(fakes, tmp_path, monkeypatch, capsys):
    FUNCTIONS["gait-table"] = fake("gait-table", error=RuntimeError("a knee"))
    out = tmp_path / "before"
    assert main.main(["experiment", "--all", "--quick", "--out", str(out)]) == main.NO_RESULT
    said = capsys.readouterr()
    assert "RuntimeError: a knee" in said.out and str(out / "figures.json") in said.out
    found = json.loads((out / "figures.json").read_text())
    assert list(found["experiments"]) == list(EXPERIMENTS) and found["quick"]
    assert found["experiments"]["gait-table"]["status"] == "RuntimeError: a knee"
    one = found["experiments"]["gait-forces"]
    assert one["figures"] == {"gait_forces_error_mm": 1.0, "gait_forces_time_s": 1.0}
    assert one["goals"] == {"gait_forces_error_mm": True}
    assert all(options["quick"] for _, options in fakes)
    places = {name: options["out"] for name, options in fakes if "out" in options}
    assert set(places.values()) == {out / name for name in places}
    assert set(places) == {name for name, e in EXPERIMENTS.items() if "out" in e.options}
    assert all(o.get("overwrite", True) for _, o in fakes), "nothing of an earlier run is counted"


def test_existing_figures_are_not_replaced_by_default(fakes, tmp_path):
    out = tmp_path / "before"
    Command(all=True, out=out, quiet=True).run()
    with pytest.raises(RunExists, match="add --overwrite"):
        Command(all=True, out=out, quiet=True).run()
    assert Command(all=True, out=out, overwrite=True, quiet=True).run().ok


def test_commands_are_listed_with_the_experiments(fakes, tmp_path, monkeypatch):
    class Fake:
        def run(self):
            metrics = {"status": "ok", "command": "x", "error_mm": 1.5, "check_ok": True}
            return experiment.Outcome("", metrics)

    words = []
    monkeypatch.setattr(experiment, "COMMANDS", {"jump": ("synthesize", "jump")})
    monkeypatch.setattr(main, "parse", lambda name, rest: words.append((name, *rest)) or Fake())
    Command(all=True, out=tmp_path, quiet=True).run()
    found = json.loads((tmp_path / "figures.json").read_text())["experiments"]["jump"]
    assert found["figures"] == {"error_mm": 1.5, "check_ok": True}
    assert words == [("synthesize", "jump", "--out", f"{tmp_path / 'jump'}",
                      "--overwrite", "--quiet")]  # fmt: skip


def test_the_listed_commands_exist():
    for words in experiment.COMMANDS.values():
        main.parse(words[0], words[1:])


def test_two_results_are_compared(fakes, tmp_path, monkeypatch, capsys):
    before, after = tmp_path / "before", tmp_path / "after"
    Command(all=True, out=before, quiet=True).run()
    FUNCTIONS["gait-forces"] = fake("gait-forces", 3.0)
    Command(all=True, out=after, quiet=True).run()
    files = [str(folder / "figures.json") for folder in (before, after)]
    assert main.main(["experiment", "--compare", *files]) == main.NO_RESULT
    said = capsys.readouterr().out
    assert "Goals lost" in said and "gait_forces_error_mm" in said and "+2e+02 %" in said
    assert main.main(["experiment", "--compare", *files[::-1], "--json"]) == main.DONE
    assert json.loads(capsys.readouterr().out)["goals_won"] == 1


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "name one experiment, or give --all or --compare"),
        (["gait-table", "--all"], "name one experiment, or give --all or --compare"),
        (["--all", "--compare", "a", "b"], "name one experiment, or give --all or --compare"),
        (["gait"], f"no experiment 'gait'; there are {next(iter(EXPERIMENTS))}, "),
        (["gait-table", "--part", "walk"], "--part has no effect with gait-table"),
        (["gait-table", "--out", "there"], "--out has no effect with gait-table"),
        (["spline-table", "--overwrite"], "--overwrite has no effect with spline-table"),
        (["synthesis-bench", "--data", "."], "--data has no effect with synthesis-bench"),
        (["--all", "--part", "walk"], "--part has no effect with --all"),
        (["--compare", "a", "b", "--out", "there"], "--out has no effect with --compare"),
        (["--compare", "a", "b", "--quick"], "--quick has no effect with --compare"),
        (["--compare", "a", "b"], "a: there is no such file"),
        (["gait-table", "--data", "nowhere"], "no folder of recordings at nowhere"),
    ],
)
def test_what_means_nothing_is_refused(words, sentence, fakes, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert main.main(["experiment", *words]) == main.BAD_INPUT
    said = capsys.readouterr()
    assert sentence in said.err and not said.out and not fakes


def test_a_part_is_one_or_several():
    command = main.parse("experiment", ["synthesis-bench", "--part", "walk", "--part", "warm"])
    assert command.parts == ("walk", "warm")


@pytest.mark.parametrize(
    ("words", "names"),
    [
        ("Name of the experiment:", set(EXPERIMENTS)),
        ("Run only this part of", {n for n, e in EXPERIMENTS.items() if "parts" in e.options}),
        ("Number of parallel runs of", {n for n, e in EXPERIMENTS.items() if "jobs" in e.options}),
    ],
)
def test_the_help_names_the_options_of_each_experiment(words, names, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "2000")
    with pytest.raises(SystemExit):
        main.parse("experiment", ["--help"])
    line = next(line for line in capsys.readouterr().out.splitlines() if words in line)
    assert {n for n in EXPERIMENTS if re.search(rf"(?<![\w-]){n}(?![\w-])", line)} == names


def test_recordings_are_welcome_where_they_are_not_needed(fakes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PLANTIGRADE_DATA", str(tmp_path / "nowhere"))
    Command(name="spline-table", quiet=True).run()
    assert fakes[-1][1]["data"] is None
    with pytest.raises(ParameterError, match="no folder of recordings"):
        Command(name="spline-table", data=tmp_path / "nowhere", quiet=True).run()
