"""Outlines of surfaces: their extent, their splines, and the dressed figure in strips."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from plantigrade import Human
from plantigrade.charts import theme
from plantigrade.contact.scene import SceneObject
from plantigrade.pages.animated_ground import WOOD
from plantigrade.pages.camera import Camera
from plantigrade.pages.scene import poses
from plantigrade.pages.silhouette import aligned, silhouettes, spline_data
from plantigrade.pages.skin_figure import PARTS, SkinFigure
from plantigrade.pages.strip import strip_svg
from plantigrade.record.scene_objects import PlacedObject

GRAIN = 0.002  # [m]


def disc(radii: tuple[float, float], centre: tuple[float, float] = (0.0, 0.0)):
    """Points and triangles of an ellipse about its centre, facing the reader."""
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radii
    k = np.arange(60)
    faces = np.stack([0 * k, 1 + (k + 1) % 60, 1 + k], axis=1)
    return np.concatenate([[[0.0, 0.0]], rim]) + centre, faces


def curve(data: str) -> np.ndarray:
    """Points of a path of one quadratic and smooth quadratic commands: the midpoints."""
    numbers = np.array(re.findall(r"-?\d+", data), dtype=float).reshape(-1, 2)
    return np.cumsum(np.delete(numbers, 1, axis=0), axis=0)


def test_the_spline_of_an_ellipse_has_its_extent_and_its_area():
    points, faces = disc((0.10, 0.05), centre=(0.3, -0.2))
    (data,) = spline_data(silhouettes(points[None], faces, 24, GRAIN), per_metre=2000)
    drawn = curve(data) / 2000
    np.testing.assert_allclose(drawn.max(axis=0), [0.4, -0.15], atol=GRAIN)
    np.testing.assert_allclose(drawn.min(axis=0), [0.2, -0.25], atol=GRAIN)
    x, y = drawn.T
    area = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    assert area == pytest.approx(np.pi * 0.10 * 0.05, rel=0.05)


def test_what_rests_for_a_while_has_one_outline():
    points, faces = disc((0.10, 0.05))
    moving = np.array([points, points + 0.02, points * 1.2])
    rests = [0, 0, 1, 2, 2, 2]
    expected = silhouettes(moving, faces, 20, GRAIN)[rests]
    np.testing.assert_array_equal(silhouettes(moving[rests], faces, 20, GRAIN), expected)


def test_smooth_commands_end_where_they_began():
    """The control of each command is the mirror image of the last: errors would add up."""
    points, faces = disc((0.10, 0.05))
    (data,) = spline_data(silhouettes(points[None], faces, 31, GRAIN), per_metre=1000)
    numbers = np.array(re.findall(r"-?\d+", data), dtype=int).reshape(-1, 2)
    start, control = numbers[0], numbers[0] + numbers[1]
    middle = start + numbers[2]
    for step in numbers[3:]:
        control, middle = 2 * middle - control, middle + step
    np.testing.assert_array_equal(middle, start)
    np.testing.assert_array_equal(2 * middle - control, start + numbers[1])


def test_triangles_that_face_away_do_not_count():
    points, faces = disc((0.05, 0.05))
    far, _ = disc((0.05, 0.05), centre=(0.5, 0.0))
    both = np.concatenate([faces, faces[:, ::-1] + len(points)])
    outline = silhouettes(np.concatenate([points, far])[None], both, 16, GRAIN)[0]
    assert outline[:, 0].max() < 0.1


def test_outlines_begin_at_corresponding_points():
    rng = np.random.default_rng(3)
    outline = rng.normal(size=(20, 2))
    turned = np.roll(outline, 7, axis=0)
    np.testing.assert_allclose(aligned(np.array([outline, turned]))[1], outline)


@pytest.fixture(scope="module")
def person() -> Human:
    return Human.create(feet="multi-segment")


def test_every_triangle_of_the_skin_belongs_to_a_part(person):
    positions, quats, _ = poses(person.model, person.standing()[None])
    figure = SkinFigure.of(person, positions, quats)
    taken = {tuple(face) for part in PARTS for face in figure.faces(part).tolist()}
    own = np.array([tuple(face) in taken for face in figure.mesh.faces.tolist()])
    a, b, c = (figure.mesh.vertices[figure.mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    assert area[own].sum() > 0.999 * area.sum()
    for part in PARTS:
        assert len(figure.faces(part)) > 20, part.name


def test_outlines_reach_as_far_as_the_skin(person):
    positions, quats, com = poses(person.model, person.standing()[None])
    figure, camera = SkinFigure.of(person, positions, quats), Camera.named("side", np.eye(3)[0])
    drawn = [figure.outlines(part, com, camera, 0.004)[0][0] for part in PARTS]
    surface = camera.project(figure.vertices[0] - com)
    corners = np.concatenate(drawn)
    np.testing.assert_allclose(corners.min(axis=0), surface.min(axis=0), atol=0.012)
    np.testing.assert_allclose(corners.max(axis=0), surface.max(axis=0), atol=0.012)


def test_a_strip_of_a_person_is_dressed_in_the_colours_of_the_sides(person):
    qpos = np.tile(person.standing(), (3, 1))
    svg = strip_svg(person.model, qpos, [0, 2], human=person, view="front", behind=qpos)
    ElementTree.fromstring(svg)
    assert theme.SKIN["sleeve_r"] in svg and theme.SKIN["sleeve_l"] in svg
    names = re.findall(r'\bid="([^"]+)"', svg)
    assert len(set(names)) == len(names)
    assert svg.count('<g opacity=".4">') == 2 and theme.REFERENCE in svg
    assert len(svg) < len(strip_svg(person.model, qpos, [0, 2], view="front", behind=qpos))


def test_objects_of_a_strip_are_before_or_behind_the_person(person):
    qpos = person.standing()[None]
    pose = np.tile([0.5, 0.0, 0.2, 1.0, 0.0, 0.0, 0.0], (1, 1))
    box = PlacedObject(SceneObject("box", "box", (0.2, 0.2, 0.2)), pose)

    def drawn(view, objects):
        svg = strip_svg(person.model, qpos, [0], human=person, view=view, objects=objects)
        ElementTree.fromstring(svg)
        return svg

    views = ("front", "back", "side")
    last = {view: drawn(view, [box]).rfind(WOOD) for view in views}
    limb = {view: drawn(view, [box]).rfind(theme.SKIN["sleeve_r"]) for view in views}
    assert last["front"] > limb["front"] and -1 < last["back"] < limb["back"]
    assert -1 < last["side"] < limb["side"]
    absent = replace(box, pose=np.full((1, 7), np.nan))
    assert drawn("front", [absent]) == drawn("front", [])


def test_an_x_ray_of_a_strip_shows_bones(person):
    qpos = person.standing()[None]
    plain = strip_svg(person.model, qpos, [0], human=person)
    assert theme.BONE not in plain and theme.BONE in strip_svg(
        person.model, qpos, [0], human=person, x_ray=True
    )


def test_bodies_whose_motion_is_assumed_are_paler(person):
    qpos = person.standing()[None]
    plain = strip_svg(person.model, qpos, [0], human=person)
    arms = {name for name in person.body_names if "humerus" in name or "arm" in name}
    assert theme.SKIN["sleeve_r"] in plain
    assert theme.SKIN["sleeve_r"] not in strip_svg(person.model, qpos, [0], human=person, pale=arms)
