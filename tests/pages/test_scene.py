"""What is drawn: shapes, poses, forces and the picture strip."""

from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.contact.site import ContactSite
from plantigrade.errors import ParameterError
from plantigrade.pages.scene import (
    MAX_FRAMES,
    build_scene,
    heading_of,
    height_below,
    nearest,
    side_forces,
    standing_height,
)
from plantigrade.pages.shapes import foot_bodies, mesh_of, shapes_of
from plantigrade.pages.strip import UNITS, strip_svg
from plantigrade.pages.viewer import viewer_html
from plantigrade.record import Record

KINDS = """<mujoco><worldbody><geom type="plane" size="5 5 .1"/><body><freejoint name="root"/>
  <geom type="sphere" size=".1"/><geom type="capsule" size=".05" fromto="0 0 0 0 .1 .3"/>
  <geom type="ellipsoid" size=".1 .15 .09"/><geom type="cylinder" size=".045 .05"/>
  <geom type="box" size=".07 .12 .1"/></body></worldbody></mujoco>"""
HILL = """<mujoco><asset><hfield name="h" nrow="3" ncol="4" size="2 1 .5 .1"
  elevation="0 0 0 0  0 1 1 0  0 0 0 0"/></asset>
  <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>"""


def site(name: str, side: str) -> ContactSite:
    return ContactSite(body="foot_r", name=name, side=side, measured=True)


def test_cop_is_where_the_load_is(record):
    """Two points with loads 3 to 1 balance at a quarter of the way; the sides do not mix."""
    force = np.zeros((1, 3, 3))
    force[0, :, 2] = [300.0, 100.0, 500.0]
    point = np.array([[[0.0, 0, 0], [0.4, 0, 0], [9.0, 0, 0]]])
    made = Record(
        record.human,
        record.motion.frames(slice(0, 1)),
        sites=(site("a", "r"), site("b", "r"), site("c", "l")),
        contact_force=force,
        contact_point=point,
    )
    total, cop = side_forces(made)
    np.testing.assert_allclose(cop[0, :2, 0], [0.1, 9.0])
    np.testing.assert_allclose(total[0, :2, 2], [400.0, 500.0])
    assert np.isnan(cop[0, 2]).all()


def test_a_force_of_no_certain_foot_has_no_side(record):
    """Both feet on one plate: what it measured is shown, but as neither foot's."""
    nobody = np.zeros(record.contact_force.shape[:2], dtype=bool)
    total, _ = side_forces(replace(record, contact_known=nobody))
    whole, _ = side_forces(record)
    np.testing.assert_allclose(total.sum(axis=1), whole.sum(axis=1))
    assert np.any(whole[:, :2]) and not np.any(total[:, :2])


def test_feet_hang_on_the_ankle(human):
    model = human.model
    names = {model.body(int(b)).name for b in np.flatnonzero(foot_bodies(model, "l"))}
    assert names == {"foot_l", "toes_l"}


def test_forces_of_another_clock_are_drawn_at_the_nearest_instant(record):
    bare = replace(record, sites=(), contact_force=None, contact_point=None)
    half = replace(
        record, motion=record.motion.frames(slice(None, None, 2)), references={},
        contact_force=record.contact_force[::2], contact_point=record.contact_point[::2],
        qfrc_actuator=None, recorded_markers=None, fitted_markers=None,
    )  # fmt: skip
    scene = build_scene(bare, forces=half, rate=50.0)
    np.testing.assert_array_equal(scene.total_force, side_forces(half)[0])
    clock = np.array([0.0, 1.0, 2.0])
    np.testing.assert_array_equal(nearest(clock, np.array([-1, 0.4, 0.6, 1.9, 7])), [0, 0, 1, 2, 2])


def test_a_reference_on_its_own_clock_is_drawn_where_it_was(record):
    other = record.references["recorded"]
    thin = replace(record, references={"other": other.frames(slice(None, None, 2))})
    whole = build_scene(replace(record, references={"other": other}), rate=100.0)
    scene = build_scene(thin, rate=100.0)
    assert scene.reference_name == "other"
    there, drawn = whole.reference_positions, scene.reference_positions
    np.testing.assert_allclose(drawn[::2], there[::2], atol=1e-9)
    np.testing.assert_allclose(drawn, there, atol=0.01)  # between: a frame's way at most


def test_the_ground_below_is_found_along_the_vertical():
    """On a slope of 45° that goes through the origin, with a step of 0.2 m along its normal."""
    ground = Ground(slope=np.pi / 4, steps=(GroundStep(1.0, 0.2),))
    points = np.array([[0.0, 0, 1.0], [0.5, 0.3, 2.0], [2.0, 0.0, 5.0]])
    below = [0.0, 0.5, 2.0 + 0.2 * np.sqrt(2)]
    np.testing.assert_allclose(height_below(ground, points), below, atol=1e-12)


def test_uphill_the_camera_follows_and_the_body_is_no_taller(record):
    qpos = record.motion.qpos.copy()
    qpos[:, 2] += 0.1 * qpos[:, 0]
    uphill = replace(record.motion, qpos=qpos)
    level = build_scene(record)
    scene = build_scene(replace(record, motion=uphill, ground=Ground(slope=np.arctan(0.1))))
    np.testing.assert_allclose(scene.floor, 0.1 * scene.com[:, 0], atol=1e-9)
    assert standing_height(scene) == pytest.approx(standing_height(level), abs=0.02)
    assert np.abs(scene.level - scene.floor).max() < 0.05


def test_who_walks_backwards_is_seen_from_the_side_asked_for(record):
    backwards = replace(record.motion, qpos=record.motion.qpos[::-1].copy())
    assert heading_of(build_scene(record)) == pytest.approx(0.0, abs=0.05)
    scene = build_scene(replace(record, motion=backwards))
    assert scene.com[-1, 0] < scene.com[0, 0] - 4
    assert heading_of(scene) == pytest.approx(0.0, abs=0.05)


def test_long_motions_are_thinned_and_the_page_says_so(record):
    n = 3 * MAX_FRAMES
    motion = replace(
        record.motion,
        time=np.arange(n) / 50,
        qpos=np.tile(record.motion.qpos[:1], (n, 1)),
        qvel=np.zeros((n, record.human.model.nv)),
    )
    long = Record(record.human, motion)
    assert len(build_scene(long).time) <= MAX_FRAMES
    assert "Long motion: 16.7 frames per second are drawn" in viewer_html(long, title="long")
    assert "Long motion" not in viewer_html(record, title="short")


def test_gaps_in_the_motion_are_refused(record):
    qpos = record.motion.qpos.copy()
    qpos[30, 8] = np.nan
    with pytest.raises(ParameterError, match="frame 30 is not finite"):
        build_scene(replace(record, motion=replace(record.motion, qpos=qpos)))
    short = replace(record.motion, qpos=qpos[:, :-1])
    with pytest.raises(ParameterError, match="configuration entries and the person"):
        build_scene(replace(record, motion=short))


def test_clocks_must_agree(record):
    markers = record.recorded_markers
    short = replace(markers, time=markers.time[:10], positions=markers.positions[:10])
    with pytest.raises(ParameterError, match=r"recorded_markers has shape \(10, "):
        build_scene(replace(record, recorded_markers=short))


def test_strip_is_true_to_scale(record):
    """Strokes of the SVG are as thick as the capsules and as far apart as their ends."""
    model = record.human.model
    tree = ElementTree.fromstring(strip_svg(model, record.motion.qpos, [0, 60, 120]))
    drawn = tree.iter("{http://www.w3.org/2000/svg}use")
    widths = {float(use.get("stroke-width", 0.0)) / UNITS for use in drawn}
    capsules = {2 * s.size[0] for s in shapes_of(model) if s.kind in ("capsule", "sphere")}
    assert all(any(abs(w - c) < 1e-3 for w in widths) for c in capsules)


def test_strip_refuses_frames_that_are_not_there(record):
    with pytest.raises(ParameterError, match="from 0 to 400"):
        strip_svg(record.human.model, record.motion.qpos, [0, 401])


def test_the_ghost_stands_behind_the_body(record):
    model, other = record.human.model, record.references["recorded"].qpos
    plain = strip_svg(model, record.motion.qpos, [10, 60])
    both = strip_svg(model, record.motion.qpos, [10, 60], behind=other)
    assert both.count('<g opacity=".4">') == 2 and '<g opacity=".4">' not in plain
    first = both.index("<g transform")
    assert both.index('<g opacity=".4">') - first < 60, "the ghost is drawn first"


def test_meshes_have_the_volume_of_their_shape():
    """Closed and of the right size: divergence theorem against the textbook volumes."""
    volume = {
        "sphere": lambda s: 4 / 3 * np.pi * s[0] ** 3,
        "capsule": lambda s: 4 / 3 * np.pi * s[0] ** 3 + 2 * np.pi * s[0] ** 2 * s[1],
        "ellipsoid": lambda s: 4 / 3 * np.pi * s[0] * s[1] * s[2],
        "cylinder": lambda s: 2 * np.pi * s[0] ** 2 * s[1],
        "box": lambda s: 8 * s[0] * s[1] * s[2],
    }
    seen = {s.kind: s for s in shapes_of(mujoco.MjModel.from_xml_string(KINDS))}
    assert set(seen) == set(volume)
    for kind, shape in seen.items():
        vertices, faces = mesh_of(shape, around=96)
        a, b, c = (vertices[faces[:, i]] for i in range(3))
        measured = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
        assert measured == pytest.approx(volume[kind](shape.size), rel=0.01), kind


def test_terrain_becomes_a_mesh_that_spans_it():
    (terrain,) = shapes_of(mujoco.MjModel.from_xml_string(HILL))
    assert terrain.kind == "mesh" and terrain.body == 0
    np.testing.assert_allclose(terrain.vertices.min(axis=0), [-2, -1, 0], atol=1e-6)
    np.testing.assert_allclose(terrain.vertices.max(axis=0), [2, 1, 0.5], atol=1e-6)
