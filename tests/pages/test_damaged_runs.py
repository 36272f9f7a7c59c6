"""Damaged but plausible run folders and policies: one sentence of our own, or whole pages.

A folder is changed where it holds numbers and words: arrays, the JSON texts among them,
``metrics.json``. What :meth:`Run.load` lets through must be drawn.
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.record.signals import SIGNALS, check_signals
from tests.nasty import runs
from tests.nasty.judge import findings
from tests.nasty.targets import run_folder
from tests.pages.walker import walk, walker

pytestmark = pytest.mark.wrong_types


def test_every_known_signal_is_in_the_run(tmp_path):
    assert set(SIGNALS) <= set(run_folder(runs.run_file("metrics.json")(tmp_path)).record.signals)


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


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_of_another_shape_makes_no_record(name):
    """The shapes a reader relies on are refused as soon as a Record is made."""
    record = runs.whole_run().record
    for value in (np.zeros((7, 7, 7, 7)), np.zeros(()), record.signals[name][:-1]):
        broken = {**record.signals, name: value}
        alone = len(record.signals[name]) == 1 or (name == "posture.end" and value.ndim == 1)
        if value.ndim == record.signals[name].ndim and alone:
            continue  # another number of things of which nothing else tells the number
        if name in ("check.findings", "solver.broken") and value.ndim == 1:
            continue
        with pytest.raises(ParameterError, match=r"signal \w+\.\w+ "):
            replace(record, signals=broken)


@pytest.mark.parametrize("name", SIGNALS)
def test_an_empty_signal_of_the_wrong_kind_makes_no_record(name):
    kind, axes = SIGNALS[name]
    value = np.zeros((0,) * len(axes), "U1" if "U" not in kind else int)
    with pytest.raises(ParameterError, match=rf"signal {name} holds"):
        check_signals({name: value}, 0, 0)


def test_signals_of_ones_own_may_be_anything():
    check_signals({"mine.table": np.zeros((3, 4)), "check.mine": np.zeros(2)}, 9, 49)


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
