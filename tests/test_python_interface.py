"""The public Python interface: ``import plantigrade as pg``."""

import dataclasses
import importlib
import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.errors import FileError, RunExists
from plantigrade.exchange import formats as export_formats
from plantigrade.io import FORMATS
from plantigrade.lazy import homes
from plantigrade.signatures import VARIES
from plantigrade.trajopt import TASKS
from plantigrade.workflows.settings import (
    FitSettings,
    PaperSettings,
    ReproduceSettings,
    SolveSettings,
    TrackSettings,
    VaultSettings,
)
from plantigrade.workflows.simulate_settings import SimulateSettings
from tests.textbook import walk_file


def python(program: str, **options) -> str:
    """Run a program in a fresh interpreter and return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, **options
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.fixture(scope="module")
def walk(tmp_path_factory) -> Path:
    """A recording: the textbook walk."""
    return walk_file(tmp_path_factory.mktemp("face") / "walk.c3d", cycles=2)


@pytest.fixture(scope="module")
def fitted(walk):
    return pg.fit(walk)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_interface_has_the_designed_names():
    assert set(pg.__all__) == {
        "Human", "Person", "Recording", "Motion", "Record", "Run", "ContactPlan", "Ground", "read",
        "fit", "reproduce", "simulate", "synthesize", "vault", "check", "compare", "fit_many",
        "retarget", "reproduce_many", "simulate_many", "synthesize_many", "report", "export",
        "load_run", "get_data", "PlantigradeError", "__version__", "view", "live_session",
    }  # fmt: skip
    assert sorted(pg.__all__) == dir(pg)


@pytest.mark.parametrize("name", sorted(set(pg.__all__) - {"__version__"}))
def test_every_name_is_there_and_documented(name):
    thing = getattr(pg, name)
    assert thing.__name__ == name and not inspect.ismodule(thing)
    assert inspect.getdoc(thing)


def test_another_name_is_not_there():
    with pytest.raises(AttributeError, match="plantigrade.*no attribute 'imagine'"):
        pg.imagine  # noqa: B018


@pytest.mark.parametrize("name", ("", ".analyze", ".models", ".ordered_tasks", ".trajopt"))
def test_what_the_checker_of_types_sees_is_what_is_loaded(name):
    package = importlib.import_module(f"plantigrade{name}")
    listed = homes(package.__name__)
    assert listed and set(listed) <= set(package.__all__)
    assert all(getattr(package, each) is not None for each in package.__all__)


def test_functions_stay_functions_whatever_is_imported():
    program = "import plantigrade as pg, plantigrade.trajopt.solve, plantigrade.pages.text; "
    program += "print({name for name in dir(pg) if inspect.ismodule(getattr(pg, name))})"
    assert python(f"import inspect; {program}") == "set()"


def test_nothing_is_loaded_before_it_is_used():
    program = "import plantigrade, sys; plantigrade.__all__; dir(plantigrade); "
    program += "print([m for m in sys.modules if m.startswith('plantigrade.') or m == 'numpy'])"
    assert python(program) == "[]"


def test_first_ten_minutes(walk, here):
    recording = pg.read(walk)
    assert isinstance(recording, pg.Recording) and recording.markers is not None
    run = pg.fit(walk)
    assert isinstance(run, pg.Run) and run.ok and run.folder is None
    knee = run.record.motion["knee_angle_r"]
    assert 0.9 < knee.max() < 1.3  # [rad]
    page = run.report()
    assert page == Path("runs/fit-walk/report.html") and page.is_file()
    again = pg.load_run(page.parent)
    np.testing.assert_array_equal(again.record.motion["knee_angle_r"], knee)
    assert again.metrics["seconds"].keys() == {"fit"}


def test_options_are_keywords_or_settings(walk):
    from plantigrade.workflows.settings import FitSettings

    settings = FitSettings(height=1.8, feet="multi-segment", joints="42", cutoff=8.0)
    both = pg.fit(str(walk), settings, feet="rigid")
    assert both.record.human.feet == "rigid" and both.record.human.height == 1.8
    assert both.provenance.settings["cutoff"] == 8.0


def test_settings_of_a_controller_are_taken_by_name_too():
    given = {"controller": "balance", "controller_settings": {"com_gain": 60}}
    with pytest.raises(pg.PlantigradeError, match="no option 'sed'; did you mean 'seed'"):
        SimulateSettings.given("simulate", None, {**given, "sed": 1})
    assert SimulateSettings.given("simulate", None, given).values == {"com_gain": 60.0}


# In a fresh interpreter, without the type checks of the tests.
WELCOME = (
    ("s.FitSettings(height=np.float32(1.5)).height", "1.5"),
    ("s.FitSettings(cutoff=8, joints=42).joints", "'42'"),
    ("s.ReproduceSettings(no_dynamics=np.True_).no_dynamics", "True"),
    ("s.SolveSettings(restarts=np.int64(2)).restarts", "2"),
    ("s.FitSettings(static='a.trc').static.name", "'a.trc'"),
    ("t.ReachSettings(target=np.array([1, 0, 1])).target", "(1.0, 0.0, 1.0)"),
    ("t.WalkSettings(heights=[0.1, 0.2, 0.2, 0.2]).heights", "(0.1, 0.2, 0.2, 0.2)"),
)
WRONG = (
    ("pg.fit(p, heigth=1.8)", "no option 'heigth'; did you mean 'height'"),
    ("pg.fit(p, height='tall')", "height must be a number, not 'tall'"),
    ("pg.fit(p, height=True)", "height must be a number, not True"),
    ("pg.fit(p, cutoff='6')", "cutoff must be a number, not '6'"),
    ("pg.fit(p, cutoff=10**5000)", "cutoff must be a number"),
    ("pg.fit(p, feet='flat')", "feet must be 'rigid' or"),
    ("pg.fit(p, static=3)", "static must be the path"),
    ("pg.fit(p, {'height': 1.8})", "settings must be FitSettings"),
    ("pg.fit(None)", "must be the path of a file"),
    ("pg.fit('')", "must be the path of a file"),
    ("pg.reproduce(p, tasks='all')", "tasks must be 'default' or"),
    ("pg.reproduce(p, no_dynamics=1)", "no_dynamics must be True or False, not 1"),
    ("pg.synthesize('wlak')", "no task 'wlak'; did you mean walk? there are walk"),
    ("pg.synthesize('walk', speed='fast')", "speed must be a number, not 'fast'"),
    ("pg.synthesize('walk', spede=1.3)", "did you mean 'speed'"),
    ("pg.synthesize('squat', speed=1.3)", "squat has no option 'speed'"),
    ("pg.synthesize('squat', depth='far')", "depth must be a number, not 'far'"),
    ("pg.synthesize('side-step', side='left')", "side must be 'r' or 'l'"),
    ("pg.synthesize('reach', target=[1.0, 2.0])", "target must be 3 numbers"),
    ("pg.synthesize('walk', solver='snopt')", "solver must be 'interior-point' or"),
    ("pg.synthesize('walk', seed=3)", "seed has no effect without restarts"),
    ("pg.synthesize('walk', seed=-1, restarts=2)", "seed must be a whole number from 0"),
    ("pg.synthesize('zhakatayev2023', motion='run')", "motion must be 'walk' or"),
    ("pg.synthesize('zhakatayev2023', speed=1.0)", "has no option 'speed'"),
    ("pg.synthesize('track')", "needs recording=FILE"),
    ("pg.synthesize('track', recording=p, speed=1.0)", "has no option 'speed'"),
    ("pg.synthesize(None)", "a task must be the path"),
    ("pg.check(p)", "only a Record or a Run can be checked"),
    ("pg.report(None)", "a run must be the path"),
    ("pg.load_run(3)", "a run must be the path"),
    ("pg.read(None)", "must be the path"),
    ("pg.get_data('deepmimick')", "no data set 'deepmimick'; did you mean deepmimic?"),
    ("pg.get_data(None)", "no data set"),
    ("pg.get_data('deepmimic', to=3)", "the folder must be the path"),
    ("pg.get_data('deepmimic', mirror=3)", "mirror must be an address"),
    ("pg.Person(mass='70')", "mass must be a number"),
)


FUNCTIONS = [getattr(pg, name) for name in pg.__all__ if inspect.isfunction(getattr(pg, name))]
TAKING = {
    pg.fit: (FitSettings, ()),
    pg.fit_many: (FitSettings, ()),
    pg.reproduce: (ReproduceSettings, ()),
    pg.reproduce_many: (ReproduceSettings, ()),
    pg.simulate: (SimulateSettings, ("norms", "own")),  # refused; the options of a controller
    pg.simulate_many: (SimulateSettings, ("norms", "own")),
    pg.synthesize: (SolveSettings, ()),
    pg.synthesize_many: (SolveSettings, ()),
    pg.vault: (VaultSettings, ("joints", "feet", "age")),  # always the same
}
INTERNAL = {"step", "command", "shared", "options"}


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_a_signature_names_and_documents_every_option(function):
    parameters = inspect.signature(function).parameters.values()
    assert not INTERNAL & {each.name for each in parameters}
    assert all(each.kind is not each.VAR_KEYWORD for each in parameters)
    assert not any(callable(each.default) for each in parameters if each.default is not each.empty)
    lines = {line.strip().split(":")[0]: line for line in inspect.getdoc(function).splitlines()}
    for each in parameters:
        assert each.annotation is not each.empty
        meaning = lines.get(each.name, "").partition(":")[2] or each.kind is each.VAR_POSITIONAL
        assert meaning or len(parameters) == 1, f"{each.name} is not described"


@pytest.mark.parametrize("function", TAKING, ids=lambda function: function.__name__)
def test_every_setting_is_a_keyword_with_its_default(function):
    settings, without = TAKING[function]
    shown = inspect.signature(function).parameters
    for each in dataclasses.fields(settings):
        assert (each.name in shown) != (each.name in without), each.name
        if each.name not in without:
            assert shown[each.name].default == each.default


def test_a_synthesis_takes_the_parameters_of_every_task():
    shown = inspect.signature(pg.synthesize).parameters
    for kind in (*TASKS.values(), TrackSettings, PaperSettings):
        for each in dataclasses.fields(kind):
            assert shown[each.name].default in (each.default, VARIES) or each.name == "basis"
    assert shown["duration"].default is VARIES and shown["steps"].default == 4
    assert shown["speed"].default is VARIES  # of a walk or a run
    assert "positive to the left [rad] (walk)" in inspect.getdoc(pg.synthesize)


def test_an_export_takes_the_options_of_every_format():
    shown = set(inspect.signature(pg.export).parameters)
    assert all(set(each.options) <= shown for each in export_formats.FORMATS)


def test_a_reader_takes_the_options_of_every_format():
    shown = set(inspect.signature(pg.read).parameters)
    for each in FORMATS:
        module, _, name = each.reader.partition(":")
        reader = getattr(importlib.import_module(f"plantigrade.io.{module}"), name)
        assert set(inspect.signature(reader).parameters) <= shown


@pytest.mark.slow
def test_a_checker_of_types_refuses_what_the_functions_refuse(here):
    Path("good.py").write_text("import plantigrade as pg\npg.fit('a.c3d', height=1.8, joints=42)\n")
    Path("wrong.py").write_text(
        "import plantigrade as pg\n"
        "pg.fit('a.c3d', heigth=1.8)\n"
        "pg.fit('a.c3d', feet='flat')\n"
        "pg.simulate(duration='long')\n"
        "pg.fit('a.c3d', step=None)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(pg.__file__).parents[1])}
    command = ["pyright", "--outputjson", "--pythonpath", sys.executable, "good.py", "wrong.py"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    found = json.loads(done.stdout)["generalDiagnostics"]
    lines = [(Path(each["file"]).name, each["range"]["start"]["line"]) for each in found]
    assert lines == [("wrong.py", line) for line in (1, 2, 3, 4)]


@pytest.fixture(scope="module")
def answers(walk) -> dict[str, str]:
    """Result of each piece of Python: its value, or the message of our error."""
    program = f"""
import json, numpy as np, plantigrade as pg
import plantigrade.trajopt.tasks.settings as t, plantigrade.workflows.settings as s
said, p = {{}}, {str(walk)!r}
for code in {[code for code, _ in (*WELCOME, *WRONG)]!r}:
    try:
        said[code] = repr(eval(code))
    except pg.PlantigradeError as error:
        said[code] = f"{{type(error).__name__}}: {{error}}"
    except Exception as error:
        said[code] = f"foreign: {{error!r}}"
print(json.dumps(said))
"""
    return json.loads(python(program))


@pytest.mark.parametrize(("code", "value"), WELCOME)
def test_numbers_of_numpy_lists_and_names_are_welcome(code, value, answers):
    assert answers[code] == value


@pytest.mark.parametrize(("code", "words"), WRONG)
def test_wrong_arguments_raise_at_once(code, words, answers):
    assert answers[code].startswith("ParameterError: ") and words in answers[code]


@pytest.mark.parametrize("call", [pg.fit, lambda p: pg.reproduce(p), pg.load_run, pg.read])
def test_a_file_that_is_not_there(call, here):
    with pytest.raises(FileError, match="nowhere"):
        call("nowhere.c3d")


def test_a_run_is_checked(fitted):
    verdict = pg.check(fitted)
    assert type(verdict).__name__ == "Verdict" and not verdict.ok  # no forces: nothing explains it
    assert pg.check(fitted.record).status == verdict.status


def test_report_saves_first_and_numbers(fitted, here):
    assert fitted.report() == Path("runs/fit-walk/report.html")
    assert fitted.report() == Path("runs/fit-walk-2/report.html")
    assert fitted.report(overwrite=True) == Path("runs/fit-walk/report.html")
    assert fitted.report("mine") == Path("mine/report.html")
    with pytest.raises(RunExists, match="mine exists"):
        fitted.report("mine")
    assert sorted(p.name for p in Path("runs").iterdir()) == ["fit-walk", "fit-walk-2"]


def test_report_of_a_saved_run_writes_its_pages_anew(fitted, here):
    run = fitted.save()
    assert run.folder == Path("runs/fit-walk") and "report.html" not in run.files
    page = run.report()
    assert page == run.folder / "report.html" and page.is_file()
    page.write_text("spoiled")
    assert pg.report(run.folder) == page
    assert "spoiled" not in page.read_text("utf-8")
    assert "report.html" in pg.load_run(run.folder).files
    run.save(run.folder, overwrite=True)  # every file of it is still known as its own
