"""A run as an animated glTF scene: a person on bones, ground, objects, forces."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.constants import SIDES
from plantigrade.exchange.bones import Bone, bone_poses, bones_of
from plantigrade.exchange.clock import require_rate
from plantigrade.exchange.gltf import Y_UP, Document, GltfSurface, normals_of, surface, together
from plantigrade.io.writing import write_bytes
from plantigrade.models import Human
from plantigrade.motion.filters import bridged_gaps
from plantigrade.pages.run_pages import title_of_run
from plantigrade.pages.scene import VIEW_RATE, Scene, build_scene
from plantigrade.pages.shapes import Shape, mesh_of, rgb
from plantigrade.record import Run
from plantigrade.skin import Skin
from plantigrade.skin.dressed import dressed_mesh
from plantigrade.skin.surface import weights_in_255ths
from plantigrade.spatial.conventions import continuous, rotation_matrix, unit_vectors

N_SIDES = 16
"""Corners of the circles of capsules: smooth to the eye at half the size of 24."""
ARROW_LENGTH = 0.6
"""Length of the arrow of one body weight [m]; that of ``viewer.html``."""
RIGID_TOLERANCE = 1e-5  #: Change of a pose [m, 1] below which two bones keep their places
MIN_SIZE = 1e-4
"""Scale of an arrow without force: zero would leave it no direction."""
FLOOR_MARGIN = 1.5  #: Distance the drawn ground reaches beyond the body's way [m]
COLOURS = {
    "skin": rgb(theme.SKIN["skin"]),
    "shirt": rgb(theme.SKIN["shirt"]),
    "sleeve_r": rgb(theme.RIGHT_BODY),
    "sleeve_l": rgb(theme.LEFT_BODY),
    "shorts_r": tuple(0.6 * part for part in rgb(theme.RIGHT_BODY)),
    "shorts_l": tuple(0.6 * part for part in rgb(theme.LEFT_BODY)),
    "eye": rgb(theme.SKIN["eye"]),
    "iris": rgb(theme.SKIN["iris"]),
}
"""Material → its colour, sRGB: left and right differ as in the viewer."""


def write_glb(
    run: Run,
    path: Path,
    rig: str = "plantigrade",
    rate: float = VIEW_RATE,
    forces: bool = False,
    solids: bool = False,
) -> tuple[str, ...]:
    """Write a run as glTF 2.0 in one binary file, y up.

    The bones are those of :mod:`plantigrade.exchange.bones`; they move the skin of the person, with
    further bones where its surface turns half-way between two. Ground and objects are nodes of
    their own.

    Args:
        rig: Whose names the bones have, one of :data:`~plantigrade.exchange.bones.RIGS`.
        rate: Frames per second [Hz]; the nearest whole fraction of the motion's rate.
        forces: Whether the ground reactions are there as arrows, :data:`ARROW_LENGTH` long per body
            weight.
        solids: Whether the solids that physics sees take the place of the skin.

    Returns:
        A note where forces are asked for that the run does not have.

    Raises:
        ParameterError: If rig or rate is not allowed, or the record cannot be drawn.
        FileError: If the file cannot be written.
    """
    require_rate(rate)
    record = run.record
    scene = build_scene(record, forces=run.with_forces, rate=rate)
    bones = bones_of(record.human, rig)
    document = Document()
    document.clock = document.accessor(scene.time - scene.time[0], extent=True)
    joints = _add_bones(document, record.human, bones, scene)
    inside = [joints[0], *_add_surroundings(document, scene, record.human.model.nbody)]
    arrows = _add_arrows(document, scene) if forces else []
    root = document.node("z_up", rotation=Y_UP, children=[*inside, *arrows])
    if solids:
        surfaces = _body_surfaces(document, record.human, bones, scene)
        bind = np.tile(np.eye(4), (len(bones), 1, 1))
        bind[:, :3, 3] = [-bone.rest for bone in bones]
    else:
        surfaces, joints, bind = _dress(document, record.human, bones, joints, scene)
    body = document.mesh("body", surfaces)
    matrices = document.accessor(np.swapaxes(bind, 1, 2))  # columns first
    document.skins.append(
        {"name": "bones", "joints": joints, "inverseBindMatrices": matrices, "skeleton": root}
    )
    skinned = document.node("body", mesh=body, skin=0)
    content = document.glb([root, skinned], title=title_of_run(run))
    write_bytes(path, content)
    return ("the run holds no ground reactions to draw",) if forces and not arrows else ()


def _add_bones(document: Document, human: Human, bones: Sequence[Bone], scene: Scene) -> list[int]:
    """Add a node for each bone, each below its parent, and return them."""
    places, turned = _poses(human, bones, scene)
    nodes = [document.node(bone.name) for bone in bones]
    for k, bone in enumerate(bones):
        if bone.parent < 0:
            place, rotation = places[:, k], turned[:, k]
        else:
            back = np.swapaxes(turned[:, bone.parent], 1, 2)
            place = np.einsum("nij,nj->ni", back, places[:, k] - places[:, bone.parent])
            rotation = back @ turned[:, k]
            document.nodes[nodes[bone.parent]].setdefault("children", []).append(nodes[k])
        document.animate(nodes[k], "translation", place)
        document.animate(nodes[k], "rotation", _quaternions(rotation))
    return nodes


def _poses(
    human: Human, bones: Sequence[Bone], scene: Scene
) -> tuple[Float[Array, "n_frames n_bones 3"], Float[Array, "n_frames n_bones 3 3"]]:
    """Return joints and rotations of bones in every frame."""
    count = human.model.nbody
    rotations = rotation_matrix(scene.quats[:, 1:count])
    return bone_poses(tuple(bones), human, scene.positions[:, 1:count], rotations)


def _dress(
    document: Document, human: Human, bones: Sequence[Bone], nodes: Sequence[int], scene: Scene
) -> tuple[list[tuple[GltfSurface, int]], list[int], Float[Array, "n_joints 4 4"]]:
    """Return the skin's surfaces, the joints that move it, and their inverse resting poses.

    A bone of the skin that keeps its place on a bone of the skeleton is moved by that one; the
    others, which turn half-way between two, become nodes below it.
    """
    skin = Skin.of(human)
    count = human.model.nbody
    names = skin.surface.bone_names
    places, turned = skin.bones.poses(scene.positions[:, :count], scene.quats[:, :count])
    carriers, carried = _poses(human, bones, scene)
    joints, bind = [], np.tile(np.eye(4), (len(names), 1, 1))
    for k, name in enumerate(names):
        above = _carrier(human, int(skin.bones.body[k]), name, bones)
        back = np.swapaxes(carried[:, above], 1, 2)
        place = np.einsum("nij,nj->ni", back, places[:, k] - carriers[:, above])
        rotation = back @ turned[:, k]
        rest = np.eye(4)
        rest[:3, :3] = skin.resting.rotation[k].T
        rest[:3, 3] = -skin.resting.rotation[k].T @ skin.resting.position[k]
        node, still = nodes[above], np.eye(4)
        rigid = max(np.ptp(place, axis=0).max(), np.ptp(rotation, axis=0).max()) < RIGID_TOLERANCE
        if rigid and node not in joints:
            still[:3, :3], still[:3, 3] = rotation[0], place[0]
        else:
            node = document.node(f"skin_{name}")
            document.nodes[nodes[above]].setdefault("children", []).append(node)
            document.animate(node, "translation", place)
            document.animate(node, "rotation", _quaternions(rotation))
        joints.append(node)
        bind[k] = still @ rest
    surfaces = [
        (part, document.material(material, COLOURS[material]))
        for material, part in dressed_surfaces(skin).items()
    ]
    return surfaces, joints, bind


def _carrier(human: Human, body: int, name: str, bones: Sequence[Bone]) -> int:
    """Return the bone of the skeleton that carries a bone of the skin: its own part's, if any."""
    own = [k for k, bone in enumerate(bones) if bone.part == name]
    if own:
        return own[0]
    while True:
        on = [k for k, bone in enumerate(bones) if human.body(bone.body) == body]
        if on:
            return on[0]
        body = int(human.model.body_parentid[body])


def _body_surfaces(
    document: Document, human: Human, bones: Sequence[Bone], scene: Scene
) -> list[tuple[GltfSurface, int]]:
    """Return the solids of the body in the zero pose, one surface per colour."""
    first = {}
    for k, bone in enumerate(bones):
        first.setdefault(bone.body, k)
    by_colour: dict[tuple[float, float, float], list[GltfSurface]] = {}
    for shape in scene.shapes:
        if not 0 < shape.body < human.model.nbody:
            continue
        k = _nearest_bone(shape, human, bones, first)
        solid = surface_of(shape)
        here = bones[k].rest - bones[k].position  # the body's origin, from the hips
        count = len(solid.vertices)
        moved = np.zeros((count, 4), dtype=int)
        moved[:, 0] = k
        weights = np.tile([255, 0, 0, 0], (count, 1))
        placed = GltfSurface(solid.vertices + here, solid.normals, solid.faces, moved, weights)
        by_colour.setdefault(shape.paint, []).append(placed)
    return [
        (together(solids), document.material(f"body_{k}", colour))
        for k, (colour, solids) in enumerate(by_colour.items())
    ]


def _nearest_bone(shape: Shape, human: Human, bones: Sequence[Bone], first: dict[str, int]) -> int:
    """Return the bone that moves a shape: of the shape's body, or of the one above it in a rig."""
    body = shape.body
    name = human.body_names[body - 1]
    while name not in first:
        body = int(human.model.body_parentid[body])
        name = human.body_names[body - 1]
    return first[name]


def _add_surroundings(document: Document, scene: Scene, bodies: int) -> list[int]:
    """Add the ground and the objects around the body, and return their nodes."""
    nodes, still = [], [shape for shape in scene.shapes if shape.body == 0]
    if not scene.plate:
        still_surfaces = [(surface_of(shape), shape.paint) for shape in still]
        if not scene.ground.steps:
            still_surfaces.append((_floor(scene), rgb(theme.FLOOR)))
        parts = [(part, document.material("ground", paint)) for part, paint in still_surfaces]
        if parts:
            nodes.append(document.node("ground", mesh=document.mesh("ground", parts)))
    for shape in scene.shapes:
        if shape.body < bodies:
            continue
        name = shape.name or "thing"
        mesh = document.mesh(name, [(surface_of(shape), document.material(name, shape.paint))])
        node = document.node(name, mesh=mesh)
        document.animate(node, "translation", scene.positions[:, shape.body])
        document.animate(
            node, "rotation", _quaternions(rotation_matrix(scene.quats[:, shape.body]))
        )
        nodes.append(node)
    return nodes


def _floor(scene: Scene) -> GltfSurface:
    """Return a rectangle of ground under all of the way."""
    along = scene.com @ scene.ground.to_world  # in the axes of the ground
    low, high = along[:, :2].min(axis=0) - FLOOR_MARGIN, along[:, :2].max(axis=0) + FLOOR_MARGIN
    corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
    flat = np.column_stack([corners, np.full(4, scene.ground.height)])
    normals = np.tile(scene.ground.normal, (4, 1))
    return GltfSurface(flat @ scene.ground.to_world.T, normals, np.array([[0, 1, 2], [0, 2, 3]]))


def _add_arrows(document: Document, scene: Scene) -> list[int]:
    """Add the ground reaction of each side as an arrow, and return the nodes."""
    if scene.total_force is None or scene.cop is None:
        return []
    nodes = []
    for row, side in enumerate((*SIDES, "")):
        force, cop = scene.total_force[:, row], scene.cop[:, row]
        seen = np.asarray(np.isfinite(cop).all(axis=1))
        if not seen.any():
            continue
        length = np.where(seen, np.linalg.norm(force, axis=1) / scene.weight * ARROW_LENGTH, 0.0)
        colour = rgb(theme.BY_SIDE[row])
        name = f"ground_reaction_{side}" if side else "ground_reaction"
        mesh = document.mesh(name, [(_arrow(), document.material(name, colour))])
        node = document.node(name, mesh=mesh)
        document.animate(node, "translation", bridged_gaps(cop, seen))
        document.animate(node, "rotation", _pointing(bridged_gaps(force, seen)))
        scale = np.maximum(length, MIN_SIZE)[:, None]
        document.animate(node, "scale", scale * [1.0, 1.0, 1.0])
        nodes.append(node)
    return nodes


def _arrow() -> GltfSurface:
    """Return an arrow along z of length 1, from the origin."""
    shaft, head, straight = 0.03, 0.07, np.array([1.0, 0.0, 0.0, 0.0])
    size = np.array([shaft, 0.4, 0.0])
    middle = np.array([0.0, 0.0, 0.4])
    cylinder = surface_of(Shape("cylinder", size, middle, straight, None, 0, ""))
    turn = np.linspace(0, 2 * np.pi, N_SIDES, endpoint=False)
    ring = np.column_stack([head * np.cos(turn), head * np.sin(turn), np.full(N_SIDES, 0.8)])
    vertices = np.vstack([ring, [0.0, 0.0, 1.0], [0.0, 0.0, 0.8]])
    k, after = np.arange(N_SIDES), (np.arange(N_SIDES) + 1) % N_SIDES
    sides = np.stack([k, after, np.full(N_SIDES, N_SIDES)], axis=1)
    base = np.stack([after, k, np.full(N_SIDES, N_SIDES + 1)], axis=1)
    return together([cylinder, surface(vertices, np.concatenate([sides, base]), flat=True)])


def _pointing(direction: Float[Array, "n 3"]) -> Float[Array, "n 4"]:
    """Return the rotations, ``xyzw``, that bring the z axis to directions."""
    # a force on the body never points straight down
    half = unit_vectors(unit_vectors(direction) + [0.0, 0.0, 1.0])
    return continuous(np.column_stack([np.cross([0.0, 0.0, 1.0], half), half[:, 2]]))


def surface_of(shape: Shape) -> GltfSurface:
    """Return the surface of a shape in the frame of its body."""
    vertices, faces = mesh_of(shape, around=N_SIDES)
    vertices = vertices @ rotation_matrix(shape.quat).T + shape.position
    return surface(vertices, faces, flat=shape.kind in ("box", "cylinder", "mesh"))


def _quaternions(rotations: Float[Array, "n 3 3"]) -> Float[Array, "n 4"]:
    """Return quaternions ``xyzw`` that go the short way from frame to frame."""
    return continuous(Rotation.from_matrix(rotations).as_quat())


def dressed_surfaces(skin: Skin) -> dict[str, GltfSurface]:
    """Return the surfaces of a skin in its resting pose, by material of :data:`COLOURS`.

    The bones are those of the skin, by index.
    """
    mesh = dressed_mesh(skin)
    normals = normals_of(mesh.vertices, mesh.faces)
    bones, weights = weights_in_255ths(mesh.bones, mesh.weights)
    found = {}
    for material in COLOURS:
        faces = mesh.faces[mesh.materials == material]
        if not len(faces):
            continue
        used, corners = np.unique(faces, return_inverse=True)
        parts = (mesh.vertices[used], normals[used], corners.reshape(-1, 3))
        found[material] = GltfSurface(*parts, bones[used], weights[used])
    return found
