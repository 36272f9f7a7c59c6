"""The moving picture: a file that stands alone, moves by itself, and shows what happened."""

import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from plantigrade import Ground
from plantigrade.charts import theme
from plantigrade.contact.ground import GroundStep, Seat
from plantigrade.contact.scene import SceneObject
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.pages.animated_ground import WOOD
from plantigrade.pages.animation import moving_picture
from plantigrade.pages.camera import VIEWS, Camera
from plantigrade.pages.outlines import outlines
from plantigrade.pages.playback import LOOP_PAUSE, playback
from plantigrade.pages.scene import poses
from plantigrade.pages.shapes import shapes_of, surface_points
from plantigrade.record.scene_objects import PLACES, object_signals
from plantigrade.spatial.conventions import rotation_matrix
from tests.textbook import walk_record

SVG = "{http://www.w3.org/2000/svg}"
PANEL_BONES = 16


@pytest.fixture(scope="module")
def walking():
    """A textbook walk on multi-segment feet: strides that repeat exactly."""
    return walk_record(Human.create(feet="multi-segment"), speed=1.3, cycles=3)


def moving_part(svg: str) -> ET.Element:
    (group,) = [g for g in ET.fromstring(svg).iter(f"{SVG}g") if g.get("class") == "moving"]
    return group


def animations(svg: str) -> list[ET.Element]:
    return [e for e in ET.fromstring(svg).iter() if e.tag.startswith(f"{SVG}animate")]


def test_a_box_that_moves_is_drawn_where_it_is(walking):
    n, half = len(walking.motion.time), (0.2, 0.15, 0.1)
    pose = np.tile([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], (n, 1))
    pose[:, :3] = walking.motion.qpos[:, :3] + [0.5, 0.0, 0.0]
    box, bar = SceneObject("box", "box", half), SceneObject("bar", "capsule", (0.05, 0.3, 0.0))
    signals = object_signals([box, bar]) | {PLACES: np.stack([pose, pose], axis=1)}
    record = replace(walking, signals={**walking.signals, **signals})
    plain, picture = (moving_picture(each, foot="none").svg for each in (walking, record))
    outlines = [path for path in moving_part(picture) if path.get("fill") == WOOD and path.get("d")]
    assert len(outlines) == 2 and not [p for p in moving_part(plain) if p.get("fill") == WOOD]
    for path, width in zip(outlines, (2 * half[0], 2 * 0.05), strict=True):
        left, _, right, _ = extent(path.get("d", ""))
        assert right - left == pytest.approx(1000.0 * width, rel=0.15)


def test_a_steady_walk_is_one_stride_that_ends_as_it_began(walking):
    picture = moving_picture(walking)
    stride = np.diff([e.time for e in walking.motion.events if e.kind == "heel_strike"][::2])
    assert picture.loop and picture.seconds == pytest.approx(stride.mean(), abs=0.02)
    for each in animations(picture.svg):
        values = each.get("values", "").split(";")
        assert len(values) == picture.frames
        if each.tag == f"{SVG}animate":  # places around the camera; the ground itself moves on
            first, last = (extent(values[k]) for k in (0, -1))
            assert np.abs(first - last).max() <= 30  # [mm]


def extent(data: str) -> np.ndarray:
    """The least and greatest place of path data: an outline may begin anywhere."""
    numbers = np.array(re.findall(r"-?\d+", data), dtype=float).reshape(-1, 2)
    if "q" in data:  # after the start: a control, relative to it, and relative midpoints
        numbers = np.delete(numbers, 1, axis=0)
    places = np.cumsum(numbers, axis=0) if re.search("[lqt]", data) else numbers
    return np.concatenate([places.min(axis=0), places.max(axis=0)])


def test_every_value_of_an_animation_has_the_same_commands(walking):
    """Otherwise a browser jumps instead of moving on between two frames."""
    for each in animations(moving_picture(walking).svg):
        shapes = {re.sub(r"[-\d .]+", "#", value) for value in each.get("values", "").split(";")}
        assert len(shapes) == 1


def test_the_enlarged_foot_has_all_its_bones_and_its_toes_bend(walking):
    svg = moving_picture(walking, foot="right").svg
    root = moving_part(svg)
    bones = [e for e in root.iter(f"{SVG}path") if re.fullmatch(r"z\d+", e.get("id", ""))]
    assert len(bones) == PANEL_BONES
    used = {e.get("href") for e in root.iter(f"{SVG}use")}
    assert {f"#{bone.get('id')}" for bone in bones} <= used
    assert "right foot" in svg and f"{PANEL_BONES} bones" in svg

    def direction(bone):
        """The axis of the outline in every frame: twice its angle, because it has no sign."""
        found = []
        for value in bone.find(f"{SVG}animate").get("values").split(";"):
            numbers = np.array(re.findall(r"-?\d+", value.partition("t")[2]), dtype=float)
            x, y = np.cumsum(numbers.reshape(-1, 2), axis=0).T
            (xx, xy), (_, yy) = np.cov(x, y)
            found.append(np.arctan2(2 * xy, xx - yy))
        return np.unwrap(found) / 2

    turns = np.array([direction(bone) for bone in bones])
    bent = np.ptp(turns[:, None] - turns[None], axis=2)
    assert np.degrees(bent.max()) > 20.0, "the foot moves as one block"


def test_the_solids_that_physics_sees_are_an_option(walking):
    """Capsules are strokes; the skin is filled, in two tones and the colours of the sides."""
    skin = moving_picture(walking, foot="none", rate=3.0).svg
    solids = moving_picture(walking, foot="none", rate=3.0, solids=True).svg
    assert "clip-path" in skin and "clip-path" not in solids
    assert theme.SKIN["sleeve_r"] in skin, "the near sleeve has the colour of its side"
    assert theme.SKIN["sleeve_r"] not in solids


def test_an_x_ray_adds_the_bones_of_both_feet(walking):
    def bones(svg):
        return sum("leg" in e.get("id", "") and re.fullmatch(r".*b\d+", e.get("id")) is not None
                   for e in moving_part(svg).iter(f"{SVG}path"))  # fmt: skip

    assert bones(moving_picture(walking, foot="none", rate=3.0).svg) == 0
    assert bones(moving_picture(walking, foot="none", rate=3.0, x_ray=True).svg) == 2 * PANEL_BONES


@pytest.mark.parametrize("foot", ["left", "none"])
def test_the_side_of_the_foot_is_named(walking, foot):
    svg = moving_picture(walking, foot=foot, rate=3.0).svg
    assert ("left foot" in svg) == (foot == "left")
    assert "right foot" not in svg


def test_forces_are_drawn_where_they_are_known(record, walking):
    with_forces = moving_part(moving_picture(record, rate=3.0).svg)
    arrows = [e for e in with_forces.iter(f"{SVG}path") if e.get("fill") == theme.FORCE]
    assert len(arrows) >= 2
    assert theme.FORCE not in moving_picture(walking, foot="none", rate=3.0).svg


def test_the_file_stands_alone_and_respects_who_wants_no_motion(walking):
    svg = moving_picture(walking, title="Walk & <run>").svg
    root = ET.fromstring(svg)
    assert not any(e.tag.endswith("script") for e in root.iter())
    links = {v for e in root.iter() for k, v in e.attrib.items() if k.endswith("href")}
    assert all(link.startswith("#") for link in links)
    assert not re.search(r"url\((?!#)", svg) and svg.count("http") == 1  # the name of SVG itself
    assert "prefers-reduced-motion:reduce" in svg
    (still,) = [g for g in root.iter(f"{SVG}g") if g.get("class") == "still"]
    assert not [e for e in still.iter() if e.tag.startswith(f"{SVG}animate")]
    assert len(list(still.iter(f"{SVG}use"))) > 50
    assert root.findtext(f"{SVG}title") == "Walk & <run>"
    assert len(svg) < 150_000


def test_no_name_comes_twice(walking):
    names = [e.get("id") for e in ET.fromstring(moving_picture(walking).svg).iter() if e.get("id")]
    assert len(set(names)) == len(names)


def test_equal_motions_give_equal_bytes(walking):
    assert moving_picture(walking, rate=3.0).svg == moving_picture(walking, rate=3.0).svg


@pytest.mark.parametrize("view", VIEWS)
def test_every_view_shows_the_whole_body(walking, view):
    root = ET.fromstring(moving_picture(walking, view=view, foot="none", rate=4.0).svg)
    left, top, width, height = (float(v) for v in root.get("viewBox", "").split())
    (moving,) = [g for g in root.iter(f"{SVG}g") if g.get("class") == "moving"]
    paths = {e.get("id"): e for e in moving.iter(f"{SVG}path") if e.get("id")}
    assert len(paths) == 18
    for path in paths.values():
        x, y = (int(v) for v in re.findall(r"-?\d+", path.get("d"))[:2])
        assert left < x < left + width and top < y < top + height


def test_what_reaches_out_is_what_the_meshes_reach(walking):
    """The outlines of ellipsoids, boxes and capsules enclose the same region as their surfaces."""
    model, motion = walking.human.model, walking.motion
    positions, quats, _ = poses(model, motion.qpos[:40:13])
    camera = Camera.named("quarter", np.array([1.0, 0.0, 0.0]))
    for shape in [s for s in shapes_of(model) if s.body]:
        place, quat = positions[:, shape.body], quats[:, shape.body]
        drawn = outlines(shape, place, quat, camera)
        turn = rotation_matrix(quat)
        axes = turn @ rotation_matrix(shape.quat)
        surface = (place + turn @ shape.position)[:, None]
        surface = camera.project(surface + surface_points(shape) @ axes.transpose(0, 2, 1))
        reach = shape.size[0] if drawn.shape[1] == 2 else 0.0
        for way in np.stack([np.cos(a := np.arange(6)), np.sin(a)], axis=1):
            true, found = (surface @ way).max(axis=1), (drawn @ way).max(axis=1) + reach
            np.testing.assert_allclose(found, true, atol=0.004)


def test_a_part_is_played_where_one_is_named(walking):
    plays = playback(walking, start=0.5, stop=1.0, rate=10.0)
    assert plays.loop is None and plays.time[0] == 0.5
    assert plays.time.max() == pytest.approx(1.0)
    assert plays.seconds == pytest.approx(0.5 + LOOP_PAUSE)
    assert moving_picture(
        walking, start=0.5, stop=1.0, speed=0.5, solids=True
    ).seconds == pytest.approx(2 * (0.5 + LOOP_PAUSE), rel=0.1)


def test_a_gait_that_changes_is_played_as_a_whole(walking):
    motion = walking.motion
    qpos = motion.qpos.copy()
    knee = 7 + motion.hinge("knee_angle_r")
    qpos[:, knee] += np.linspace(0, 1.5, len(qpos))
    changed = replace(walking, motion=replace(motion, qpos=qpos))
    assert playback(walking).loop is not None and playback(changed).loop is None


def test_slopes_steps_and_seats_are_drawn(walking):
    def ground(svg):
        inside = moving_part(svg)
        return {e.get("fill"): e.get("d", "") for e in inside.iter(f"{SVG}path") if e.get("fill")}

    from plantigrade.pages.animated_ground import TOP, WOOD

    flat = moving_picture(walking, foot="none", solids=True).svg
    sloped = moving_picture(
        replace(walking, ground=Ground(slope=0.1)), foot="none", solids=True
    ).svg
    stairs = Ground(steps=(GroundStep(0.5, 0.15), GroundStep(1.0, 0.3)))
    stepped = moving_picture(replace(walking, ground=stairs), foot="none", solids=True).svg
    assert len(ground(stepped)[TOP]) > len(ground(flat)[TOP])
    assert ground(sloped)[TOP] != ground(flat)[TOP]
    seat = Ground(seats=(Seat("seat_r", (0.0, -0.1, 0.45)), Seat("seat_l", (0.0, 0.1, 0.45))))
    assert (
        WOOD not in flat and WOOD in moving_picture(replace(walking, ground=seat), solids=True).svg
    )


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"view": "above"}, "view is 'above'"),
        ({"foot": "both"}, "foot is 'both'"),
        ({"speed": 0.0}, "speed=0.0"),
        ({"speed": float("nan")}, "speed=nan"),
        ({"rate": float("inf")}, "rate=inf"),
        ({"rate": 0.0}, "rate=0.0"),
        ({"start": 2.0, "stop": 1.0}, "not within this motion"),
        ({"start": -1.0}, "not within this motion"),
        ({"stop": 1e9}, "not within this motion"),
        ({"start": float("nan")}, "not within this motion"),
        ({"start": 0.5, "stop": 0.5000001}, "too short for a picture"),
        ({"stop": 1e-300}, "too short for a picture"),
        ({"height_px": 0}, "height_px=0"),
    ],
)
def test_values_that_mean_nothing_are_refused(walking, values, words):
    with pytest.raises(ParameterError, match=re.escape(words)):
        moving_picture(walking, **values)


def test_rigid_feet_need_no_bones(record):
    assert "bones" not in moving_picture(record, rate=3.0).svg


def test_it_moves_in_a_browser(browser, walking, tmp_path):
    """As an image, where no script runs."""
    (tmp_path / "walk.svg").write_text(moving_picture(walking).svg, encoding="utf-8")
    page = tmp_path / "page.html"
    page.write_text('<!doctype html><img src="walk.svg" width="700">', encoding="utf-8")
    browser.open(page)
    first = browser.screenshot()
    for _ in range(20):
        later = browser.screenshot()
        if (later != first).sum() > 1000:
            break
    else:
        pytest.fail("twenty pictures in a row are alike")
    assert not browser.errors
