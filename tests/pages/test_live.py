"""The live viewer: what is sent to the browser, and how the command ends."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace
from threading import Event
from types import SimpleNamespace

import numpy as np
import pytest

from plantigrade.charts import theme
from plantigrade.contact.ground import Ground, GroundStep, Seat
from plantigrade.pages.live import LiveViewer
from plantigrade.pages.live_parts import ARROW_PER_BODY_WEIGHT, HEAD_LENGTH, in_bytes, turned_to
from plantigrade.pages.scene import build_scene, side_forces
from plantigrade.pages.viewer import COLOURS, page_data
from plantigrade.spatial.conventions import rotation_matrix
from tests.pages.runs import fitted


@pytest.fixture
def live(record):
    """A viewer of the walk."""
    viewer = LiveViewer(record, port=8439)
    yield viewer
    viewer.close()


def nodes(viewer: LiveViewer) -> dict:
    """Return what stands in the scene, by name."""
    return dict(viewer.server.scene._handle_from_node_name)


def test_colours_are_those_of_the_page(live, record):
    page = page_data(record, live.scene)
    sent = {tuple(node.color) for name, node in nodes(live).items() if "/body/" in name and
            hasattr(node, "color")}  # fmt: skip
    assert sent == {in_bytes(tuple(s["colour"])) for s in page["shapes"] if s["body"]}
    arrows = [{tuple(part.color) for part in arrow} for arrow in live._arrows]
    assert arrows == [{in_bytes(colour)} for colour in page["side_colours"]]
    assert arrows[:2] == [{in_bytes(COLOURS["right"])}, {in_bytes(COLOURS["left"])}]
    clouds = {name: tuple(cloud.colors) for name, cloud in live._clouds.items()}
    assert clouds == {name: in_bytes(COLOURS[name]) for name in ("recorded", "fitted")}
    assert tuple(live._com.color) == in_bytes(COLOURS["com"])
    ghost = [node.color for name, node in nodes(live).items() if "/reference/" in name and
             hasattr(node, "color")]  # fmt: skip
    assert {tuple(colour) for colour in ghost} == {in_bytes(COLOURS["reference"])}
    assert theme.BY_SIDE == tuple(page["side_colours"])


def test_an_arrow_stands_on_the_centre_of_pressure_and_is_as_long_as_the_force(live, record):
    total, cop = side_forces(record)
    frame = 30  # of 50 Hz, where the walk has 100
    live.show(frame)
    drawn = 0
    for side, (shaft, head, disc) in enumerate(live._arrows):
        seen = np.isfinite(cop[2 * frame, side]).all()
        assert (shaft.visible, head.visible, disc.visible) == (seen,) * 3
        if seen:
            drawn += 1
            turn = rotation_matrix(np.array(head.wxyz))
            tip = np.array(head.position) + HEAD_LENGTH * head.scale * turn[:, 2]
            force = ARROW_PER_BODY_WEIGHT * total[2 * frame, side] / record.weight
            np.testing.assert_allclose(tip, cop[2 * frame, side] + force, atol=1e-5)
            middle = np.array(shaft.position) - turn[:, 2] * shaft.scale[2] / 2
            np.testing.assert_allclose(middle, cop[2 * frame, side], atol=1e-5)
    assert drawn > 0


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0.0, -0.8)])
def test_the_turn_to_a_direction(direction):
    turned = rotation_matrix(turned_to(np.array(direction, float))) @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose(turned, direction, atol=1e-12)


def test_chair_and_stairs_stand_where_they_are(record):
    seats = (Seat("a", (-0.3, -0.1, 0.45)), Seat("b", (-0.3, 0.1, 0.45)))
    for ground, names in (
        (Ground(seats=seats), {"seat_0"}),
        (
            Ground(steps=(GroundStep(1.0, 0.15), GroundStep(1.3, 0.3))),
            {"floor", "floor_1", "floor_2"},
        ),
    ):
        moved = replace(record, ground=ground)
        viewer = LiveViewer(moved, port=8440)
        try:
            fixed = {s.name: s for s in build_scene(moved).shapes if not s.body}
            assert set(fixed) == names
            for name in names:
                top = fixed[name].position[2] + fixed[name].size[2]
                number = int(name.partition("_")[2] or 0)
                heights = (0.45,) if "seat" in name else (0.0, 0.15, 0.3)
                assert top == pytest.approx(heights[number])
            meshes = [n for n, node in nodes(viewer).items() if "0_world/" in n and
                      hasattr(node, "vertices")]  # fmt: skip
            assert len(meshes) == len(names)
            assert ("/world/ground" in nodes(viewer)) == (not ground.steps)
        finally:
            viewer.close()


def test_the_grid_lies_on_the_slope(record):
    ground = Ground(slope=0.1)
    viewer = LiveViewer(replace(record, ground=ground), port=8441)
    try:
        up = rotation_matrix(np.array(nodes(viewer)["/world/ground"].wxyz))[:, 2]
        np.testing.assert_allclose(up, ground.normal, atol=1e-9)
    finally:
        viewer.close()


def test_ground_that_moves_is_a_plate_and_no_part_of_the_body(record):
    place = np.linspace([0.0, 0.0, 0.0, 0.0], [0.2, 0.0, 0.1, 0.0], record.motion.n_frames)
    signals = {**record.signals, "ground.place": place}
    viewer = LiveViewer(replace(record, signals=signals), port=8439)
    try:
        drawn = nodes(viewer)
        assert "/world/ground" not in drawn
        (plate,) = [name for name in drawn if "_ground/" in name]
        assert plate.startswith("/world/plate/")
        (handle, body), last = viewer._plate[0], len(viewer.scene.time) - 1
        viewer.show(last)
        np.testing.assert_allclose(handle.position, viewer.scene.positions[last, body], atol=1e-6)
        assert handle.position[0] > 0.19
    finally:
        viewer.close()


def test_the_last_frame_stays_and_the_speed_is_true(live, monkeypatch):
    """Three late looks at the clock: no time is lost, and none is made up."""
    from plantigrade.pages import live as module

    ticks = iter([0.0, 0.7, 2.0, 4.1, 4.7])
    monkeypatch.setattr(module, "clock", SimpleNamespace(monotonic=lambda: next(ticks)))
    seen, show = [], live.show
    monkeypatch.setattr(
        live, "show", lambda frame: (seen.append(live.scene.time[frame]), show(frame))
    )

    class Stop(Event):
        left = 4

        def wait(self, timeout=None):
            self.left -= 1
            return self.left < 0

    live.play(Stop())
    assert seen == pytest.approx([0.7, 2.0, 4.0, 0.0])


def test_the_command_prints_an_address_and_ends_with_ctrl_c(tmp_path, record):
    fitted(record).save(tmp_path / "run")
    view = subprocess.Popen(
        [sys.executable, "-m", "plantigrade", "view", str(tmp_path / "run"), "--no-open", "--json",
         "--port", "8442"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ},
        # in the background of a shell the signal would be ignored, and for ever
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert view.stderr is not None
    try:
        line = view.stderr.readline()
        assert line.startswith("Viewer at http://localhost:"), line
        view.send_signal(signal.SIGINT)
        out, err = view.communicate()
    finally:
        view.kill()
    assert view.returncode == 0, err
    assert "Traceback" not in err
    assert json.loads(out)["kind"] == "fit"
