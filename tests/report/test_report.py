"""What the pages say, without a browser."""

import base64
import json
import re
import time
from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from plantigrade.report.curves import panels_of
from plantigrade.report.report import ReportData, Section, report_html

from plantigrade.charts import Series, line_plot, ticks_of
from plantigrade.errors import ParameterError
from plantigrade.motion import Motion, Table
from plantigrade.record import Record
from plantigrade.report.live import mesh_of
from plantigrade.report.scene import MAX_FRAMES, build_scene, foot_bodies, shapes_of, side_forces
from plantigrade.report.strip import strip_svg
from plantigrade.report.viewer import encode, viewer_html
from tests.report.data import report_data
from tests.report.walker import walk


def bare(record: Record) -> Record:
    return Record(motion=record.motion)


def payload(page: str) -> dict:
    found = re.search(r'<script type="application/json" id="scene">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found[1])


def decoded(item: dict) -> np.ndarray:
    words = np.frombuffer(base64.b64decode(item["data"]), "<u2").astype(float)
    return np.where(words == 65535, np.nan, item["low"] + words * item["step"])


def test_budget(model, record):
    """Four seconds at 100 Hz: under 3 MB and 3 s each."""
    start = time.perf_counter()
    viewer = viewer_html(model, record, title="Walk")
    report = report_html(model, record, report_data(model, record))
    assert time.perf_counter() - start < 3
    assert len(viewer) < 3e6 and len(report) < 3e6


@pytest.mark.parametrize("make", ["viewer", "report"])
def test_no_outside_address(model, record, make):
    page = (
        viewer_html(model, record, title="Walk")
        if make == "viewer"
        else report_html(model, record, report_data(model, record))
    )
    outside = set(re.findall(r"(?:https?:)?//[\w.-]+\.\w+[^\s\"'<]*", page))
    assert outside <= {"http://www.w3.org/2000/svg"}


def test_page_keeps_poses_and_gaps(model, record):
    """What the page decodes is what was recorded, to a millimetre; unseen markers stay unseen."""
    data = payload(viewer_html(model, record, title="Walk", rate=50.0))
    frames = np.arange(0, record.motion.n_frames, 2)
    assert data["time"] == pytest.approx(record.motion.time[frames], abs=1e-5)
    shown = decoded(data["recorded"]).reshape(len(frames), -1, 3)
    there = record.recorded_markers.positions[frames]
    assert np.array_equal(np.isnan(shown), np.isnan(there))
    np.testing.assert_allclose(shown, there, atol=1e-3)
    position = decoded(data["positions"]).reshape(len(frames), -1, 3)
    np.testing.assert_allclose(position[:, 1], record.motion.qpos[frames, :3], atol=1e-3)


def test_encode_is_within_a_step():
    values = np.random.default_rng(0).normal(size=(50, 3))
    values[7, 1] = np.nan
    item = encode(values)
    np.testing.assert_allclose(decoded(item), values.ravel(), atol=0.51 * item["step"])
    assert np.isnan(decoded(encode(np.full(4, np.nan)))).all()
    np.testing.assert_array_equal(decoded(encode(np.full(3, 2.5))), 2.5)


def test_long_motions_are_thinned(model, record):
    n = 3 * MAX_FRAMES
    motion = Motion(
        time=np.arange(n) / 50,
        qpos=np.tile(record.motion.qpos[:1], (n, 1)),
        qvel=np.zeros((n, model.nv)),
        joint_names=record.motion.joint_names,
    )
    assert len(build_scene(model, Record(motion=motion)).time) <= MAX_FRAMES


def test_title_cannot_inject(model, record):
    hostile = "</script><script>alert(1)</script>"
    record = replace(record, warnings=(hostile,))
    for page in (
        viewer_html(model, record, title=hostile, curves={hostile: np.sin(record.motion.time)}),
        report_html(model, record, ReportData(title=hostile, provenance={"command": hostile})),
    ):
        assert "<script>alert" not in page


def test_cop_is_where_the_load_is(model, record):
    """Two points with loads 3 to 1 balance at a quarter of the way; the sides do not mix."""
    force = np.zeros((1, 3, 3))
    force[0, :, 2] = [300.0, 100.0, 500.0]
    point = np.array([[[0.0, 0, 0], [0.4, 0, 0], [9.0, 0, 0]]])
    one = Motion(
        record.motion.time[:1], record.motion.qpos[:1], record.motion.qvel[:1],
        record.motion.joint_names,
    )  # fmt: skip
    made = Record(
        motion=one, contact_force=force, contact_point=point, contact_side=("r", "r", "l")
    )
    total, cop = side_forces(made, 700.0)
    np.testing.assert_allclose(cop[0, :2, 0], [0.1, 9.0])
    np.testing.assert_allclose(total[0, :2, 2], [400.0, 500.0])
    assert np.isnan(cop[0, 2]).all()


def test_feet_hang_on_the_ankle(model):
    names = {model.body(int(b)).name for b in np.flatnonzero(foot_bodies(model, "l"))}
    assert names == {"calcn_l", "toes_l"}


@pytest.mark.parametrize("kind", ["viewer", "report", "strip"])
def test_nothing_but_a_motion(model, record, kind):
    """A record without markers, forces or events still gives every page."""
    if kind == "viewer":
        assert "Recorded markers" not in viewer_html(model, bare(record), title="Bare")
    elif kind == "report":
        page = report_html(model, bare(record), ReportData(title="Bare"))
        assert "there were no markers" in page and "no ground reaction" in page
    else:
        ElementTree.fromstring(strip_svg(model, record.motion.qpos, [0, 50]))


def test_a_single_frame(model):
    record = walk(model, duration=0.02)
    motion = replace(
        record.motion, time=record.motion.time[:1], qpos=record.motion.qpos[:1],
        qvel=record.motion.qvel[:1], events=(),
    )  # fmt: skip
    alone = Record(motion=motion)
    assert payload(viewer_html(model, alone, title="One"))["time"] == [0.0]
    assert "NaN" not in report_html(model, alone, ReportData(title="One"))


@pytest.mark.parametrize("page", [viewer_html, report_html])
def test_a_foreign_motion_is_refused(model, record, page):
    short = replace(record.motion, qpos=record.motion.qpos[:, :-1])
    with pytest.raises(ParameterError, match="configuration entries and the model"):
        if page is viewer_html:
            page(model, replace(record, motion=short), title="x")
        else:
            page(model, replace(record, motion=short), ReportData(title="x"))


def test_gaps_in_the_motion_are_refused(model, record):
    qpos = record.motion.qpos.copy()
    qpos[30, 8] = np.nan
    with pytest.raises(ParameterError, match="frame 30 is not finite"):
        build_scene(model, replace(record, motion=replace(record.motion, qpos=qpos)))


def test_clocks_must_agree(model, record):
    markers = record.recorded_markers
    short = replace(markers, time=markers.time[:10], positions=markers.positions[:10])
    with pytest.raises(ParameterError, match="recorded_markers has 10 frames"):
        build_scene(model, replace(record, recorded_markers=short))


def test_failed_status_is_shown(model, record):
    failed = replace(record, metrics={"status": "did not converge"})
    assert '<span class="badge">did not converge</span>' in report_html(
        model, failed, ReportData(title="Walk")
    )


def test_engines_add_sections(model, record):
    section = Section("Solver", text="It took 3 iterations.", headers=["a"], rows=[["1"]])
    page = report_html(model, record, ReportData(title="Walk", extra=[section]))
    assert "It took 3 iterations." in page


def test_strip_is_true_to_scale(model, record):
    """Strokes of the SVG are as thick as the capsules and as far apart as their ends."""
    tree = ElementTree.fromstring(strip_svg(model, record.motion.qpos, [0, 60, 120]))
    lines = tree.iter("{http://www.w3.org/2000/svg}line")
    widths = {float(line.get("stroke-width")) for line in lines}
    capsules = {2 * s.size[0] for s in shapes_of(model) if s.kind in ("capsule", "sphere")}
    assert all(any(abs(w - c) < 1e-3 for w in widths) for c in capsules)


def test_strip_refuses_frames_that_are_not_there(model, record):
    with pytest.raises(ParameterError, match="from 0 to 400"):
        strip_svg(model, record.motion.qpos, [0, 401])


def test_curves_pair_left_and_right(record):
    time = record.motion.time
    table = Table(
        ("knee_angle_l", "knee_angle_r", "pelvis_tx", "mtp_angle_r"),
        time,
        np.column_stack([np.sin(time), np.cos(time), time, 0 * time]),
    )
    knee, pelvis = panels_of(table, len(time))  # the toe does not move and is left out
    assert [line.label for line in knee.lines] == ["right", "left"]
    assert (knee.unit.strip(), pelvis.unit.strip()) == ("°", "m")
    assert knee.lines[0].values[0] == pytest.approx(np.degrees(1.0))


def test_curves_must_fit_the_motion(record):
    with pytest.raises(ParameterError, match="has shape"):
        panels_of({"knee_angle_r": np.zeros(3)}, record.motion.n_frames)


@pytest.mark.parametrize("low, high", [(-1e-4, 3e-4), (0, 1), (-170, 30), (1e5, 9e5), (2, 2)])
def test_ticks_lie_inside(low, high):
    ticks = ticks_of(low, high)
    assert ticks and all(low - 1e-9 <= t <= high + 1e-9 for t in ticks) and len(ticks) <= 10


def test_a_plot_without_data_is_still_a_drawing():
    nothing = np.full(5, np.nan)
    svg = line_plot([Series(np.arange(5.0), nothing)], title="t", x_label="x", y_label="y")
    ElementTree.fromstring(svg)
    assert "nan" not in svg.lower().replace("sans", "")


def test_live_meshes_have_the_volume_of_their_shape(model):
    """Closed and of the right size: divergence theorem against the textbook volumes."""
    volume = {
        "sphere": lambda s: 4 / 3 * np.pi * s[0] ** 3,
        "capsule": lambda s: 4 / 3 * np.pi * s[0] ** 3 + 2 * np.pi * s[0] ** 2 * s[1],
        "ellipsoid": lambda s: 4 / 3 * np.pi * s[0] * s[1] * s[2],
        "cylinder": lambda s: 2 * np.pi * s[0] ** 2 * s[1],
        "box": lambda s: 8 * s[0] * s[1] * s[2],
    }
    seen = {shape.kind: shape for shape in shapes_of(model)}
    assert set(seen) == set(volume)
    for kind, shape in seen.items():
        vertices, faces = mesh_of(shape, around=96)
        a, b, c = (vertices[faces[:, i]] for i in range(3))
        measured = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
        assert measured == pytest.approx(volume[kind](shape.size), rel=0.01), kind


def test_terrain_and_meshes_are_drawn():
    """A height field becomes a mesh that spans it, and then no flat ground is drawn."""
    xml = """<mujoco><asset><hfield name="h" nrow="3" ncol="4" size="2 1 .5 .1"
      elevation="0 0 0 0  0 1 1 0  0 0 0 0"/></asset>
      <worldbody><geom type="hfield" hfield="h"/>
      <body pos="0 0 1"><freejoint name="root"/><geom type="sphere" size=".1"/></body>
      </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    terrain = next(s for s in shapes_of(model) if s.kind == "mesh")
    np.testing.assert_allclose(terrain.vertices.min(axis=0), [-2, -1, 0], atol=1e-6)
    np.testing.assert_allclose(terrain.vertices.max(axis=0), [2, 1, 0.5], atol=1e-6)
    motion = Motion(np.zeros(1), np.array([[0, 0, 1, 1, 0, 0, 0.0]]), np.zeros((1, 6)), ("root",))
    assert payload(viewer_html(model, Record(motion=motion), title="Hill"))["ground"] is False


def test_a_force_of_no_certain_foot_has_no_side(model, record):
    """Both feet on one plate: what it measured is shown, but as neither foot's."""
    nobody = np.zeros(record.contact_force.shape[:2], dtype=bool)
    weight = 600.0
    total, _ = side_forces(replace(record, contact_known=nobody), weight)
    whole, _ = side_forces(record, weight)
    np.testing.assert_allclose(total.sum(axis=1), whole.sum(axis=1))
    assert np.any(whole[:, :2]) and not np.any(total[:, :2])


def test_stillness_looks_still():
    """A tenth of a degree does not fill a plot that spans ten."""
    x = np.linspace(0, 1, 50)
    drawing = line_plot(
        [Series(x, 0.05 * np.sin(6 * x))], title="a", x_label="b", y_label="c", least=10.0
    )
    path = re.findall(r'<path d="([^"]*)"', drawing)[0]
    heights = [float(pair.split()[1]) for pair in re.split("[ML]", path) if pair]
    assert np.ptp(heights) < 3
