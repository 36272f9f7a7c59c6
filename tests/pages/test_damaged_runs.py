"""Damaged but plausible run folders and policies: one sentence of our own, or whole pages.

A folder is changed where it holds numbers and words: arrays, the JSON texts among them,
``metrics.json``. What :meth:`Run.load` lets through must be drawn.
"""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.record.signals import SIGNALS, check_signals, signal_of
from tests.nasty import runs
from tests.nasty.judge import findings
from tests.nasty.targets import run_folder
from tests.pages.walker import walk, walker

pytestmark = pytest.mark.wrong_types


SHAPED = [name for name, signal in SIGNALS.items() if not signal.has_any_shape]


def test_every_known_signal_is_in_the_run(tmp_path):
    """Of a family one member; those of controllers have no shape of their own."""
    held = run_folder(runs.run_file("metrics.json")(tmp_path)).record.signals
    expected = {name for name in SIGNALS if not name.startswith("controller.")}
    assert expected <= {signal_of(name).name for name in held}


@pytest.mark.parametrize(
    ("name", "count"),
    [("run: motion.npz", 40), ("run: forces.npz", 30), ("run: metrics.json", 60), ("policy", 20)],
)
def test_mutants(tmp_path, name, count):
    """Arrays, their JSON texts, figures, members of the zip in turn are others or missing."""
    assert findings(name, tmp_path, count) == []


@pytest.mark.parametrize("name", ["run used: motion.npz", "run used: metrics.json"])
def test_what_is_loaded_is_drawn(tmp_path, name):
    assert findings(name, tmp_path, 2) == []


@pytest.mark.parametrize("name", SHAPED)
def test_a_signal_of_another_shape_makes_no_record(name):
    """The shapes a reader relies on are refused as soon as a Record is made."""
    record = runs.whole_run().record
    held = next(each for each in record.signals if signal_of(each).name == name)
    value = np.zeros((7,) * (record.signals[held].ndim + 1), record.signals[held].dtype)
    with pytest.raises(ParameterError, match=rf"signal {held} has shape"):
        replace(record, signals={**record.signals, held: value})


@pytest.mark.parametrize("name", [n for n in SHAPED if SIGNALS[n].shape.count(" ")])
def test_axes_of_one_name_are_equally_long(name):
    """One frame, task, measure or percent less than the other signals of the family have."""
    record = runs.whole_run().record
    held = next(each for each in record.signals if signal_of(each).name == name)
    short = record.signals[held][..., :-1]
    if name in ("spline.multipliers.*", "foot.names"):
        short = record.signals[held][:-1]
    with pytest.raises(ParameterError, match=r"signal [\w.]+ has shape"):
        replace(record, signals={**record.signals, held: short})


@pytest.mark.parametrize("name", SHAPED)
def test_an_empty_signal_of_the_wrong_kind_makes_no_record(name):
    signal = SIGNALS[name]
    value = np.zeros((0,) * len(signal.axes), "U1" if signal.kind != "word" else int)
    with pytest.raises(ParameterError, match=rf"signal {re.escape(name)} holds"):
        check_signals({name: value}, 0, 6)


def test_an_unknown_signal_makes_no_record():
    record = runs.whole_run().record
    with pytest.raises(
        ParameterError, match=r"'tasks.residuals'; did you mean tasks.residual. there are .*user"
    ):
        replace(record, signals={**record.signals, "tasks.residuals": np.zeros(2)})


def test_signals_of_ones_own_may_be_anything():
    own = {"user.table": np.zeros((3, 4)), "controller.mine": np.zeros(2), "live.wind": np.ones(9)}
    check_signals(own, 9, 49)


def test_signals_of_another_version_become_the_user_s_own(tmp_path):
    """Old folders are read: no name that this version does not know is lost, or refused."""
    path = runs.run_file("motion.npz")(tmp_path)
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **arrays, **{"signal/solver.time": np.arange(3.0)})
    np.testing.assert_array_equal(run_folder(path).record.signals["user.solver.time"], [0, 1, 2])


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"recorded_markers": None}, "fitted_markers need recorded_markers"),
        ({"fitted_markers": np.zeros((3, 2, 3))}, "fitted_markers has shape"),
        ({"references": {"x": "shorter"}}, "reference 'x' is not a motion of this person"),
    ],
)
def test_parts_of_another_motion_make_no_record(changes, match):
    record = walk(walker(), duration=0.2)
    if "references" in changes:
        changes = {"references": {"x": record.motion.frames(slice(0, 0))}}
    with pytest.raises(ParameterError, match=match):
        replace(record, **changes)


def test_a_signal_of_half_precision_is_loaded_without_a_warning(tmp_path):
    """Its numbers were compared with a limit that half precision cannot hold."""
    path = runs.run_file("motion.npz")(tmp_path)
    with np.load(path) as archive:
        arrays = dict(archive)
    half = arrays["signal/tasks.residual"].astype(np.float16)
    np.savez(path, **{**arrays, "signal/tasks.residual": half})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run_folder(path).record.signals["tasks.residual"].shape == half.shape
