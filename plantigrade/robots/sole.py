"""The sole of a robot's foot, from the shapes with which it touches the ground."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float

SOLE_THICKNESS = 0.01  # [m] above its lowest point; feet have rounded edges
CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
RIM_ANGLES = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)  # [rad] places on a rim


@dataclass(frozen=True, eq=False)
class Sole:
    """A flat sole: spheres, or points where the radius is zero, fixed to one body.

    The frame of the sole has its origin below the ankle on the ground on which the robot stands, x
    forward, y to the left, z up.
    """

    body: int  #: The body that it belongs to
    origin: Float[Array, " 3"]  #: Origin of the sole's frame in the body's frame [m]
    rotation: Float[Array, "3 3"]  #: Axes of the sole in the body's frame, as columns
    points: Float[Array, "n 3"]  #: Centres of the spheres in the sole's frame [m]
    radius: Float[Array, " n"]  #: Their radii [m]

    def edge(self, end: str) -> Float[Array, " 3"]:
        """Return the centre of the sphere about which the foot rolls over ``"heel"`` or ``"toe"``.

        It is in the sole's frame, in the middle of the foot's width [m].
        """
        x = self.points[:, 0]
        k = int(x.argmin() if end == "heel" else x.argmax())
        return np.array([x[k], 0.0, self.points[k, 2]])

    def lowest(self, position: Float[Array, " 3"], rotation: Float[Array, "3 3"]) -> float:
        """Return the height of the lowest point of the sole in a pose [m]."""
        return float((position[2] + self.points @ rotation[2] - self.radius).min())


def sole_of(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    bodies: list[int],
    ankle: Float[Array, " 3"],
    forward: Float[Array, " 3"],
) -> Sole:
    """Return the sole of a foot of a robot that stands.

    Args:
        bodies: The last body of the leg that a joint moves, and what is welded to it.
        ankle: Position of the ankle [m].
        forward: Where the robot faces, horizontal.
    """
    own = np.isin(model.geom_bodyid, bodies)
    touching = own & ((model.geom_contype | model.geom_conaffinity) != 0)
    geoms = np.flatnonzero(touching if touching.any() else own)
    centres, radii = (
        np.concatenate(part)
        for part in zip(*(_spheres(model, data, geom) for geom in geoms.tolist()), strict=True)
    )
    heights = centres[:, 2] - radii
    kept = heights < heights.min() + SOLE_THICKNESS
    axes = np.column_stack([forward, np.cross([0.0, 0.0, 1.0], forward), [0.0, 0.0, 1.0]])
    below = np.array([*ankle[:2], heights.min()])
    body = data.xmat[bodies[0]].reshape(3, 3)
    return Sole(
        bodies[0],
        body.T @ (below - data.xpos[bodies[0]]),
        body.T @ axes,
        (centres[kept] - below) @ axes,
        radii[kept],
    )


def _spheres(model, data, geom: int) -> tuple[Float[Array, "n 3"], Float[Array, " n"]]:
    """Return spheres, or points, whose hull is the shape of a geom, world [m]."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    radius = 0.0
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        local, radius = np.zeros((1, 3)), size[0]
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        local, radius = np.array([[0.0, 0.0, -size[1]], [0.0, 0.0, size[1]]]), size[0]
    elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        rim = size[0] * np.column_stack([np.cos(RIM_ANGLES), np.sin(RIM_ANGLES)])
        local = np.concatenate([np.insert(rim, 2, z, axis=1) for z in (-size[1], size[1])])
    elif kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        local = model.mesh_vert[first : first + model.mesh_vertnum[mesh]].astype(float)
    else:  # a box, or the box around an ellipsoid
        local = CORNERS * size
    axes = data.geom_xmat[geom].reshape(3, 3)
    return data.geom_xpos[geom] + local @ axes.T, np.full(len(local), radius)
