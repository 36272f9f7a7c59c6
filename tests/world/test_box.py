"""Bars, boxes and packs are in the record of a world, in its exported scene and in its pictures."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade.contact.scene import SceneObject
from plantigrade.control import passive
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.pages.scene import build_scene, side_forces
from plantigrade.pages.viewer import viewer_html
from plantigrade.record import Run
from plantigrade.record.scene_objects import scene_objects_of
from plantigrade.workflows.simulate import simulate
from plantigrade.world import Barrier, Load, Push, ThrownBox, World

HUMAN = Human.create(1.75, 70.0, "male", "42", "rigid")
ACTING = (
    Barrier(ahead=2.0, height=1.5),
    ThrownBox(mass=2.0, size=(0.2, 0.3, 0.4), time=0.1),
    Load(8.0),
    Push(force=150.0, duration=0.1, time=0.05),
)


@pytest.fixture(scope="module")
def record():
    return World(HUMAN, None, ACTING).simulate(passive, 0.3)


def test_objects_are_where_they_were(record):
    bar, box, pack = scene_objects_of(record)
    assert bar.fixed and not box.fixed
    assert [each.scene_object.kind for each in (bar, box, pack)] == ["capsule", "box", "box"]
    assert bar.pose[0, :3] == pytest.approx([2.0, 0.0, 1.52])
    time, there = record.motion.time, np.isfinite(box.pose[:, 0])
    assert np.array_equal(there, time > 0.1 - 1e-9) and box.scene_object.size == (0.1, 0.15, 0.2)
    falls = box.pose[there, 2]
    assert falls[5] - falls[0] == pytest.approx(-0.5 * 9.81 * (time[5] - time[0]) ** 2, rel=0.05)
    trunk = record.human.body("torso")
    data = mujoco.MjData(record.human.model)
    data.qpos[:] = record.motion.qpos[0]
    mujoco.mj_forward(record.human.model, data)
    behind = data.xmat[trunk].reshape(3, 3).T @ (pack.pose[0, :3] - data.xipos[trunk])
    assert behind == pytest.approx([-0.2, 0.0, 0.05], abs=1e-9)


def test_they_are_kept_and_what_stands_is_in_the_exported_scene(record, tmp_path):
    run = Run(record, "simulate", "title", "sentence", "ok").save(tmp_path / "run")
    again = Run.load(run.folder).record
    for old, new in zip(scene_objects_of(record), scene_objects_of(again), strict=True):
        assert old.scene_object == new.scene_object and np.array_equal(
            old.pose, new.pose, equal_nan=True
        )
    model = mujoco.MjModel.from_xml_path(str(run.folder / "model.xml"))
    bar = model.geom("thing_0")
    assert model.nq == HUMAN.model.nq and bar.pos == pytest.approx([2.0, 0.0, 1.52])
    along = np.zeros(9)
    mujoco.mju_quat2Mat(along, bar.quat)
    assert np.abs(along.reshape(3, 3)[:, 2]) == pytest.approx([0.0, 1.0, 0.0])
    with pytest.raises(KeyError):  # what moves is no part of it
        model.geom("thing_1")


def test_objects_are_drawn_and_do_not_change_the_stature(record):
    scene = build_scene(record)
    things = [shape for shape in scene.shapes if shape.is_scene_object]
    assert [shape.kind for shape in things] == ["capsule", "box", "box"]
    assert [shape.body for shape in things] == [HUMAN.model.nbody + i for i in range(3)]
    assert scene.positions.shape[1] == HUMAN.model.nbody + 3
    bare = {k: v for k, v in record.signals.items() if not k.startswith("things.")}
    page = viewer_html(record, title="t")
    assert '"pushes":[' in page and '"thing":true' in page
    assert '"thing":true' not in viewer_html(replace(record, signals=bare), title="t")


def test_a_push_is_no_reaction_of_the_ground_in_the_viewer(record):
    scene = build_scene(record)
    assert [record.sites[k].name for k in scene.pushes] == ["push_torso"]
    pushed = np.flatnonzero(record.contact_force[:, scene.pushes[0], 0])
    assert side_forces(record)[0][pushed, 2, 0] == pytest.approx(150.0)
    assert not scene.total_force[:, 2].any()


def test_objects_without_a_shape_are_refused():
    for kind, size in (
        ("cone", (0.1, 0.1, 0.1)),
        ("box", (0.1, -0.1, 0.1)),
        ("box", (0.0, 1.0, 1.0)),
    ):
        with pytest.raises(ParameterError):
            SceneObject("it", kind, size)


def test_a_record_with_an_impossible_object_is_refused(record):
    for name, bad in (
        ("things.kind", np.array(["cone"] * 3)),
        ("things.size", -record.signals["things.size"]),
        ("things.size", record.signals["things.size"][:2]),
    ):
        with pytest.raises(ParameterError, match=r"scene object|thing"):
            replace(record, signals={**record.signals, name: bad})


def test_what_begins_after_the_end_is_refused():
    with pytest.raises(
        ParameterError, match=r"a push would begin at 3 s, but the simulation lasts 1 s"
    ):
        simulate(duration=1.0, push=("50,0.1,0,3",))
    with pytest.raises(ParameterError, match="a thrown box would begin at 3 s"):
        simulate(duration=1.0, box=("2,5,0,3",))
