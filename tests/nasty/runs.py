"""Run folders to damage: one that has everything a run may have, solved ones, and a fitted one."""

import functools
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from plantigrade.record import Condition, Record, Run
from tests.nasty.seeds import Make, Wholes
from tests.pages.runs import from_tasks, solved
from tests.pages.walker import walk, walker


def spline(nv: int) -> dict[str, np.ndarray]:
    """Return the signals of a synthesised motion from which another one may start."""
    return {
        "spline.basis": np.array("cubic"),
        "spline.status": np.array("solved"),
        "spline.nodes": np.linspace(0.0, 2.4, 4),
        "spline.switches": np.zeros(0),
        "spline.coordinates": np.array([f"q{i}" for i in range(nv)]),
        "spline.unknowns": np.array(["force x of heel_r"]),
        "spline.coefficients": np.zeros((6, nv)),
        "spline.forces": np.zeros((3, 1)),
        "spline.period": np.array([1.0, 0.6]),
        "spline.aside": np.array([0.3]),
        "spline.multipliers.contact": np.zeros((3, 3, 2)),
    }


def signals(record: Record) -> dict[str, np.ndarray]:
    """Return one of every signal that the package knows, and of every family of signals."""
    n, nv = record.motion.qvel.shape
    assert record.fitted_markers is not None
    tasks = dict(from_tasks(walk(walker(), duration=0.1)).record.signals)
    on = np.ones((n, 5), bool)
    return {
        **solved(record, bad=True).record.signals,
        **tasks,
        "tasks.active": on,
        "tasks.residual": np.outer(np.ones(n), [0.0, 1e-12, 1e-3, 1.0, 100.0]),
        "controller.com_error": np.full(n, 1e-3),
        "live.speed": np.ones(n),
        "user.table": np.zeros((3, 4)),
        "exact": np.ones(n, bool),
        "stopped": np.array("no acceleration was found"),
        "assumed.joints": np.array(["mtp_angle_r"]),
        "markers.residual": np.full(record.fitted_markers.shape[:2], 0.01),
        "world.motor": np.zeros((n, nv - 6)),
        "world.push": np.zeros((n, 3)),
        **spline(nv),
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
        "device.torque": np.tile(-5.0 * (np.arange(nv) == 10), (n, 1)),
        "device.without": np.ones((n, nv)),
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


@functools.cache
def whole_run() -> Run:
    """Return a run that has everything a run may have, its ground and a second record among it."""
    record = walk(walker(), duration=2.4, rate=25.0)
    run = solved(record, bad=True)
    knee = Condition("knee", "coordinate", (0.0, 0.5), (0.0, 0.0), (0.2, 0.3), "knee_angle_r")
    everything = replace(
        run.record,
        conditions=(knee,),
        signals=signals(record),
        references=record.references,
        recorded_markers=record.recorded_markers,
        fitted_markers=record.fitted_markers,
    )
    return replace(run, record=everything, others={"forces": record})


def run_file(name: str) -> Make:
    """Return what makes that run, for one of its files to be damaged."""

    def make(folder: Path) -> Path:
        whole_run().save(folder / "run")
        return folder / "run" / name

    return make


def stored_runs(name: str) -> Wholes:
    """Return what lists solved motions that lie beside the tests, and a fitted recording."""

    def copied(source: Path) -> Make:
        def make(folder: Path) -> Path:
            shutil.copytree(source, folder / "run")
            return folder / "run" / name

        return make

    def fitted(source: Path) -> Make:
        def make(folder: Path) -> Path:
            import plantigrade as pg

            pg.fit(source).save(folder / "run")
            return folder / "run" / name

        return make

    def listed(data: Path | None) -> Iterator[tuple[str, Make]]:
        stored = Path(__file__).parents[1] / "stored"
        yield from ((each, copied(stored / each)) for each in ("side-step", "sit-to-stand"))
        if data is not None:
            walk = data / "opensim" / "rajagopal_walk" / "markers_walk.trc"
            yield from ((path.stem, fitted(path)) for path in (walk,) if path.exists())

    return listed
