"""Damaged but plausible run folders: one sentence of our own, or whole pages; nothing else.

A folder is changed where it holds numbers and words: arrays, the JSON texts among them,
``metrics.json``. What :meth:`Run.load` lets through must be drawn.
"""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import FileError, ParameterError
from plantigrade.record import Condition, Record, Run
from plantigrade.record.signals import SIGNALS, check_signals
from plantigrade.report.pages import pages
from tests import nasty
from tests.report.runs import from_tasks, solved
from tests.report.walker import walk, walker

pytestmark = pytest.mark.wrong_types


def signals(record: Record) -> dict[str, np.ndarray]:
    """Return one of every signal the package knows."""
    n, nv = record.motion.qvel.shape
    tasks = dict(from_tasks(walk(walker(), duration=0.1)).record.signals)
    on = np.ones((n, 5), bool)
    return {
        **solved(record, bad=True).record.signals,
        **tasks,
        "tasks.active": on,
        "tasks.residual": np.outer(np.ones(n), [0.0, 1e-12, 1e-3, 1.0, 100.0]),
        "solver.time": np.full(n, 1e-3),
        "foot.percent": np.linspace(0, 100, 101),
        "foot.names": np.array(["hindfoot_dorsiflexion_r"]),
        "foot.hindfoot_dorsiflexion_r": np.zeros((2, 101)),
        "norms.people": np.array(["our people"]),
        "norms.names": np.array(["knee_angle", "hip_flexion"]),
        "norms.mean": np.zeros((2, 101)),
        "norms.sd": np.ones((2, 101)),
        "forces.measured": np.arange(2 * n).reshape(n, 2) % 3 > 0,
        "forces.band": np.ones((n, 2, 3)),
        "forces.point_band": np.full((n, 2, 2), 0.01),
        "forces.torque_band": np.ones((n, 2)),
        "forces.moment_band": np.ones((n, nv)),
        "estimated.force": np.ones((n, 2, 3)),
        "measured.force": np.zeros((n, 2, 3)),
        "measured.moment": np.zeros((n, 1)),
        "measured.moment_names": np.array(["knee_angle_r"]),
        "ground.place": np.full((n, 4), 0.01),
        "barrier.clearance": np.full(n, 0.05),
        "things.name": np.array(["barrier"]),
        "things.kind": np.array(["capsule"]),
        "things.size": np.array([[0.02, 1.5, 0.0]]),
        "things.place": np.tile([3.0, 0.0, 1.6, 1.0, 0.0, 0.0, 0.0], (n, 1, 1)),
        "vault.joints": np.array(["shoulder", "hip"]),
        "vault.activation": np.zeros((n, 2)),
        "vault.changed": np.array(["speed", "speed"]),
        "vault.change": np.array([[-0.05, 2.0, np.nan], [0.05, 2.1, 2.2]]),
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Run:
    """A run that has everything a run may have."""
    record = walk(walker(), duration=2.4, rate=25.0)
    run = solved(record, bad=True)
    knee = Condition("knee", "coordinate", (0.0, 0.5), (0.0, 0.0), (0.2, 0.3), "knee_angle_r")
    whole = replace(
        run.record, conditions=(knee,), signals=signals(record), references=record.references
    )
    run = replace(run, record=whole)
    return run.save(tmp_path_factory.mktemp("damaged") / "run")


def attempt(run: Run, what: object, *, draw: bool) -> bool:
    """Load a run, and draw it; return whether it was loaded. Our own error may end the loading."""
    assert run.folder is not None
    try:
        loaded = Run.load(run.folder)
    except FileError as error:
        assert error.remedy and "\n" not in str(error), what
        return False
    except Exception as error:
        raise AssertionError(what) from error
    if draw:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # of means of nothing
            try:
                assert set(pages(loaded)) == {"report.html", "viewer.html"}
            except Exception as error:
                raise AssertionError(what) from error
    return True


def test_every_known_signal_is_in_the_run(made):
    assert set(SIGNALS) <= set(Run.load(made.folder).record.signals)
    assert attempt(made, "nothing", draw=True)


@pytest.mark.slow
def test_arrays(made):
    """Each array in turn is missing, shorter, longer, of another kind, empty of sense, or huge."""
    path = made.folder / "motion.npz"
    raw = path.read_bytes()
    with np.load(path) as archive:
        arrays = dict(archive)
    changes = [(key, *new) for key in arrays for new in nasty.arrays(arrays[key])]
    drawn = 0
    for key, what, array in nasty.sample(changes, 80):
        kept = {k: v for k, v in (arrays | {key: array}).items() if v is not None}
        np.savez(path, **kept)
        drawn += attempt(made, (key, what), draw=drawn < 4 * nasty.EFFORT)
    path.write_bytes(raw)
    assert drawn


@pytest.mark.parametrize("key", ["human", "ground", "conditions"])
def test_texts_of_json(made, key):
    """Each value of the JSON inside the arrays in turn is another."""
    path = made.folder / "motion.npz"
    raw = path.read_bytes()
    with np.load(path) as archive:
        arrays = dict(archive)
    value = json.loads(str(arrays[key]))
    if key == "ground":
        place = {"centre": [0, 0, 0], "radius": 0.1}
        value |= {"steps": [{"x": 9.0, "height": 0.1}], "bumps": [place]}
        value["seats"] = [{"site": "chair", "position": [0, 0, 0.4]}]
        value["field"] = {"corner": [0, 0], "spacing": [1, 1], "heights": [[0, 0], [0, 0.1]]}
    changes = [(place, new) for place in nasty.leaves(value) for new in nasty.VALUES]
    drawn = 0
    for place, new in nasty.sample(changes, 25):
        text = np.array(json.dumps(nasty.replaced(value, place, new)))
        np.savez(path, **(arrays | {key: text}))
        drawn += attempt(made, (key, place), draw=drawn < 2 * nasty.EFFORT)
    path.write_bytes(raw)
    assert drawn


def test_metrics(made):
    """Each value of ``metrics.json`` in turn is another, each of its words too."""
    path = made.folder / "metrics.json"
    text = path.read_text(encoding="utf-8")
    value = json.loads(text)
    changes = [(place, new) for place in nasty.leaves(value) for new in nasty.VALUES]
    raw = [
        (place, json.dumps(nasty.replaced(value, place, new)).encode())
        for place, new in nasty.sample(changes, 40)
    ]
    drawn = 0
    for what, content in [*raw, *nasty.texts(text, 40)]:
        path.write_bytes(content)
        drawn += attempt(made, what, draw=drawn < 4 * nasty.EFFORT)
    path.write_text(text, encoding="utf-8")
    assert drawn


def test_archives(made):
    """Headers of arrays, members, the zip's directory."""
    path = made.folder / "motion.npz"
    raw = path.read_bytes()
    for what, content in nasty.archives(raw):
        path.write_bytes(content)
        attempt(made, what, draw=False)
    path.write_bytes(raw)


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_of_another_shape_makes_no_record(made, name):
    """The shapes a reader relies on are refused as soon as a Record is made."""
    record = made.record
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
