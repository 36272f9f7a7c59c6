"""Targets, the damaged data and their readers: every format, run folders, task files, option files.

A reader returns, or raises one of our own errors, or :class:`BadValue` where it let through what
nobody can have measured. New formats join by adding a line to :data:`TARGETS`.
"""

import json
import os
import signal
import warnings
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from pathlib import Path

import numpy as np

from experiments.cached_results import CachedResults
from experiments.figures import compare, read_figures
from plantigrade import __version__
from plantigrade.analyze import compare_runs
from plantigrade.analyze.norms_of_runs import read_norms
from plantigrade.control.gait.reference import reference_of
from plantigrade.errors import PlantigradeError
from plantigrade.io import read, write
from plantigrade.io.c3d_writer import write_c3d
from plantigrade.io.csv import write_csv
from plantigrade.io.osim_body import OsimHuman
from plantigrade.io.text import read_text
from plantigrade.io.trc import write_trc
from plantigrade.learn.policy import Policy
from plantigrade.models import Human
from plantigrade.models.markers import place_markers, read_marker_set
from plantigrade.motion import Recording
from plantigrade.pages.batch import FITS, page_html_of
from plantigrade.pages.run_pages import pages
from plantigrade.record import Run
from plantigrade.record.batch import BatchFolder
from plantigrade.record.folder import FORMAT
from plantigrade.record.inputs import inputs
from plantigrade.record.metrics import METRICS
from plantigrade.trajopt import read_task_file
from tests import nasty
from tests.io.osim_files import every_joint
from tests.nasty import npz, runs, seeds

MOST = 1e12
"""Largest number of a recording that was read [SI]."""


class BadValue(AssertionError):
    """Something was read that nobody can have measured."""


def require(met: bool, what: str) -> None:
    """Refuse what was read unless a condition is met."""
    if not met:
        raise BadValue(what)


def sane(recording: Recording) -> None:
    """Check that clocks run, shapes agree, and numbers are finite or missing."""
    require(bool(parts(recording) or recording.outputs), "nothing was read, without an error")
    for where, part in parts(recording).items():
        time = part.time
        require(bool(np.isfinite(time).all()), f"{where}: a time that is not finite")
        require(bool((np.diff(time) > 0).all()), f"{where}: time does not increase")
        for name, array in arrays_of(part).items():
            require(not np.isinf(array).any(), f"{where}: {name} infinite")
            require(float(np.nanmax(np.abs(array), initial=0.0)) <= MOST, f"{where}: {name} huge")
            lengths = {"corners": 4, "rest_positions": len(getattr(part, "names", ()))}
            right = len(array) == lengths.get(name, len(time))
            require(right, f"{where}: {name} has another length")
        names = getattr(part, "names", ())
        if isinstance(names, tuple) and hasattr(part, "names"):
            require(len(set(names)) == len(names), f"{where}: two have one name")
            columns = getattr(part, "positions", getattr(part, "values", None))
            require(columns.shape[1] == len(names), f"{where}: another number of columns")
    if recording.skeleton is not None:
        body = recording.skeleton
        require(bool(np.isfinite(body.positions).all()), "skeleton: positions are not finite")
        before = all(parent < i for i, parent in enumerate(body.parents))
        require(before, "skeleton: a parent comes after its child")
    require(all(np.isfinite(event.time) for event in recording.events), "events: not finite")
    person = recording.subject
    for value in (person.height, person.mass, person.leg_length, person.age):
        require(value is None or 0 <= value <= MOST, f"the person has {value}")


def parts(recording: Recording) -> dict:
    """Return what has a clock."""
    found = {name: getattr(recording, name) for name in ("markers", "skeleton", "coordinates")}
    found |= {f"plate {i}": plate for i, plate in enumerate(recording.plates)}
    return {name: part for name, part in found.items() if part is not None}


def arrays_of(part: object) -> dict[str, np.ndarray]:
    """Return the arrays of numbers that a part of a recording holds."""
    assert is_dataclass(part)
    values = {each.name: getattr(part, each.name) for each in fields(part)}
    return {name: value for name, value in values.items() if isinstance(value, np.ndarray)}


def motion_file(path: Path) -> None:
    """Read a recording."""
    sane(read(path))


def converted(path: Path) -> None:
    """Read a recording, and write it in each format that can hold it."""
    recording = read(path)
    for ending in ("c3d", "trc", "csv", "mot", "bvh"):
        target = path.with_name(f"converted.{ending}")
        try:
            write(recording, target)
        except PlantigradeError:  # not every format can hold it
            continue
        finally:
            target.unlink(missing_ok=True)


def skeleton_file(path: Path) -> None:
    """Read the motion beside a skeleton."""
    sane(read(next(path.parent.glob("*.amc"))))


def run_folder(path: Path) -> Run:
    """Load the run that a file belongs to."""
    run = Run.load(path.parent)
    motion = run.record.motion
    for name in ("time", "qpos", "qvel"):
        require(bool(np.isfinite(getattr(motion, name)).all()), f"{name} of a run is not finite")
    require(bool((np.diff(motion.time) > 0).all()), "time of a run does not increase")
    return run


def used_run(path: Path) -> None:
    """Load a run, and draw, compare and replay it: what is loaded can be drawn."""
    run = run_folder(path)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # of means of nothing
        made = pages(run)
        require(set(made) == {"report.html", "viewer.html"}, "pages are missing")
        for use in (lambda: compare_runs([run], ["a"]), lambda: reference_of(run.record)):
            try:
                use()
            except PlantigradeError:  # not every motion is a walk, or can be followed
                pass


@cache
def person() -> Human:
    """Return who does the tasks."""
    return Human.create(height=1.7, mass=65.0)


def task_file(path: Path) -> None:
    """Make the task of a task file."""
    with np.errstate(over="ignore"):  # of a step of 1e-308 m
        read_task_file(path).task(person())


def marker_set(path: Path) -> None:
    """Place the markers of a set."""
    own = read_marker_set(path)
    place_markers([*own.landmarks, *own.fixed], person(), own)


def own_model(path: Path) -> None:
    """Read an OpenSim model, and move it."""
    own = OsimHuman.of(read_text(path), path)
    names, values = own.to_coordinates(own.standing()[None])
    require(len(names) == len(own.every_coordinate), "another number of coordinates")
    require(bool(np.isfinite(values).all()), "a pose is not finite")
    require(bool(np.isfinite(own.slopes(own.defaults())).all()), "a slope is not finite")


def norms_file(path: Path) -> None:
    """Read norms."""
    for name, (mean, sd) in read_norms(path).curves.items():
        require(mean.shape == sd.shape == (101,), f"{name} has another shape")
        require(bool(np.isfinite([mean, sd]).all() and (sd >= 0).all()), f"{name} is not finite")


def kept_results(path: Path) -> None:
    """Take up results of an experiment."""
    CachedResults(path)


def policy_file(path: Path) -> None:
    """Load a policy, and ask it once."""
    policy = Policy.load(path)
    require(bool(np.isfinite(policy(np.zeros((1, len(policy.mean))))).all()), "it decides nothing")


def figures_file(path: Path) -> None:
    """Compare figures of experiments with those of the seed."""
    found = read_figures(path)
    compare(json.loads(seeds.FIGURES), found).text()


def batch_journal(path: Path) -> None:
    """Take up the batch that a journal is of, and write its tables and its page."""
    spec = {"method": "fit", "settings": {}}
    marked = {"format": FORMAT, "kind": "batch", "version": __version__, **spec, "files": []}
    path.with_name(METRICS).write_text(json.dumps(marked))
    (path.parent / "curves.jsonl").write_text(seeds.BATCH_CURVES)
    try:
        store = BatchFolder(path.parent, spec, "", overwrite=False)
        with np.errstate(all="ignore"):
            page = page_html_of(FITS, store, FITS.counts(()))
        store.finish({"status": "ok"}, {"batch.html": page})
    finally:
        for each in path.parent.iterdir():
            if each != path:
                each.unlink()


def input_list(path: Path) -> None:
    """Read a list of files."""
    inputs([], fits=Path.is_file, listed=path)


@dataclass(frozen=True)
class Target:
    """A kind of file.

    Attributes:
        name: Of the target.
        read: Reads what was damaged.
        make: Makes a small valid file.
        ways: Ways to damage it.
        wholes: Lists whole files of that kind.
        cost: How much longer than the reader of a text it takes for the same bytes.
    """

    name: str
    read: Callable[[Path], object]
    make: seeds.Make
    ways: tuple[nasty.Mutation, ...] = nasty.TEXT
    wholes: seeds.Wholes = seeds.no_others
    cost: float = 1.0

    @property
    def writes(self) -> bool:
        """Whether it writes files, which it removes."""
        return self.read in (converted, batch_journal)

    @property
    def has_remedies(self) -> bool:
        """Whether each refusal says what to do: of TOML, what is wrong is enough."""
        return self.read not in (task_file, marker_set)


TARGETS = {
    each.name: each
    for each in (
        Target("C3D", motion_file, seeds.written("a.c3d", write_c3d), nasty.C3D,
               seeds.recordings("c3d/*.c3d")),
        Target("TRC", motion_file, seeds.written("a.trc", write_trc),
               wholes=seeds.recordings("opensim/*/*.trc")),
        Target("MOT/STO", motion_file, seeds.text("a.mot", seeds.COORDINATES),
               wholes=seeds.recordings("opensim/*/*.mot")),
        Target("STO of forces", motion_file, seeds.text("a.sto", seeds.FORCES_OF_FEET),
               wholes=seeds.recordings("opensim/*/*.sto")),
        Target("CSV", motion_file, seeds.written("a.csv", write_csv),
               wholes=seeds.as_table("opensim/*/*walk*.trc")),
        Target("BVH", motion_file, seeds.text("a.bvh", seeds.BVH),
               wholes=seeds.recordings("cmu_bvh/*.bvh")),
        Target("AMC", motion_file, seeds.amc,
               wholes=seeds.recordings("cmu_asfamc/*.amc", "{start}.asf")),
        Target("ASF", skeleton_file, seeds.asf,
               wholes=seeds.recordings("cmu_asfamc/*.asf", "{start}_*.amc")),
        Target("DeepMimic", motion_file, seeds.text("a.json", seeds.DEEPMIMIC), nasty.JSON,
               seeds.recordings("deepmimic/*.txt")),
        Target("keypoints", motion_file, seeds.text("a.json", seeds.KEYPOINTS), nasty.JSON),
        Target("forces", motion_file, seeds.text("a.forces", seeds.PLATES),
               wholes=seeds.long_text("a.forces", seeds.LONG_PLATES)),
        Target("npz", motion_file, seeds.npz, npz.NPZ, runs.stored_runs("motion.npz")),
        Target("SMPL", motion_file, seeds.smpl("a.npz"), npz.NPZ, cost=3.0),
        Target("SMPL pickle", motion_file, seeds.smpl("a.pkl"), nasty.PICKLE, cost=3.0),
        Target("SMPL pickle of people", motion_file, seeds.smpl("a.pkl", "1"), nasty.PICKLE,
               cost=3.0),
        *(
            Target(f"converted: {name}", converted, make, ways, cost=3.0)
            for name, make, ways in (
                ("C3D", seeds.written("a.c3d", write_c3d), nasty.C3D),
                ("TRC", seeds.written("a.trc", write_trc), nasty.TEXT),
                ("CSV", seeds.written("a.csv", write_csv), nasty.TEXT),
                ("BVH", seeds.text("a.bvh", seeds.BVH), nasty.TEXT),
                ("npz", seeds.npz, npz.NPZ),
            )
        ),
        Target("norms", norms_file, seeds.text("a.csv", seeds.NORMS)),
        Target("OpenSim model", own_model, seeds.text("a.osim", every_joint()), cost=10.0),
        Target("marker set", marker_set, seeds.text("a.toml", seeds.MARKER_SET)),
        Target("task: squat", task_file, seeds.text("a.toml", seeds.SQUAT),
               wholes=seeds.tasks),
        Target("task: walk", task_file, seeds.text("a.toml", seeds.WALK), cost=3.0),
        Target("figures", figures_file, seeds.text("a.json", seeds.FIGURES), nasty.JSON),
        Target("kept results", kept_results, seeds.text("a.json", '{"a": {"x": 1.0}}'), nasty.JSON),
        Target("batch", batch_journal, seeds.text("items.jsonl", seeds.BATCH_ITEMS), nasty.TEXT,
               cost=20.0),
        Target("list", input_list, seeds.text("a.txt", "walk.c3d\nruns/*.trc\n# mine\n.\n")),
        Target("policy", policy_file, seeds.policy, npz.NPZ, seeds.policies, cost=5.0),
        Target("run: motion.npz", run_folder, runs.run_file("motion.npz"), npz.NPZ,
               runs.stored_runs("motion.npz"), cost=20.0),
        Target("run: metrics.json", run_folder, runs.run_file("metrics.json"), nasty.JSON,
               runs.stored_runs("metrics.json"), cost=10.0),
        Target("run: forces.npz", run_folder, runs.run_file("forces.npz"), npz.NPZ,
               cost=10.0),
        Target("run used: motion.npz", used_run, runs.run_file("motion.npz"), npz.VALUES,
               runs.stored_runs("motion.npz"), cost=200.0),
        Target("run used: metrics.json", used_run, runs.run_file("metrics.json"),
               nasty.JSON_VALUES, runs.stored_runs("metrics.json"), cost=200.0),
    )
}  # fmt: skip
"""Every kind of file that is read, by name."""


def _endless(_: Path) -> None:
    while True:
        pass


def _crash(_: Path) -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def _foreign(path: Path) -> None:
    raise KeyError(path.name)


def _writing(path: Path) -> None:
    path.with_name("left-behind").touch()


def _greedy(_: Path) -> None:
    np.ones(10**8).sum()


BROKEN = {
    f"broken: {name}": Target(f"broken: {name}", read, seeds.text("a.txt", "1 2\n"), cost=200.0)
    for name, read in {
        "hang": _endless,
        "crash": _crash,
        "foreign exception": _foreign,
        "files": _writing,
        "memory": _greedy,
    }.items()
}
"""Readers that misbehave on purpose, whose findings show that the command works."""
TARGETS |= BROKEN
