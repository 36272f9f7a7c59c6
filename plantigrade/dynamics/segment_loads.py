r"""Distribution of a measured ground reaction over the segments of a foot.

A plate measures one wrench per foot; its distribution over segments cannot be measured. Joints
above the foot are independent of the choice, joints within it are not.

* ``rigid``: the foot.
* ``two-segment``: the toes if the centre of pressure lies ahead of the toe joint, otherwise the
  hindfoot, as is usual [Stefanyshyn1997]_; the lever arm of the toe joint moment then starts near
  zero.
* ``multi-segment``: every contact point :math:`i` carries the share :math:`s_i \ge 0` of the force,
  with :math:`\sum s_i = 1`, :math:`\sum s_i p_i` equal to the centre of pressure, and minimum
  :math:`\sum s_i^2 / w_i`; :math:`w_i = \exp(-h_i / h_0)` decreases with the height of the point
  above the lowest one. The remainder for a centre of pressure outside the sole is a moment on the
  segment with the largest share, so that the sum equals the measurement.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import BodyState, sweep
from plantigrade.models import Human

HEIGHT_SCALE = 0.01  # [m] height at which the weight of a contact point falls to 1/e. Chosen


@dataclass(frozen=True)
class SegmentLoad:
    """Load on one body, a force at a point and a torque, world axes."""

    body: int  #: Index of the body in the model
    force: Float[Array, " 3"]  #: Force [N]
    point: Float[Array, " 3"]  #: Point of application [m]
    torque: Float[Array, " 3"]  #: Torque [N m]


@dataclass(frozen=True)
class SegmentForces:
    """Load on each segment of the feet over a motion."""

    side: tuple[str, ...]  #: ``"r"`` or ``"l"`` of each segment
    segment: tuple[str, ...]  #: Name without side; the body is ``{segment}_{side}``
    force: Float[Array, "n_frames n_segments 3"]  #: Force, world [N]; zero if unloaded
    #: Point of application, world [m]; NaN if unloaded
    point: Float[Array, "n_frames n_segments 3"]
    torque: Float[Array, "n_frames n_segments 3"]  #: Torque at that point, world [N m]


class SegmentLoads:
    """Distributes ground reactions over the segments of one person's feet."""

    def __init__(self, human: Human):
        """Look up the bodies and contact points of both feet."""
        self.feet = human.feet
        self.foot = {s: human.body(f"foot_{s}") for s in SIDES}
        self.toes = {s: human.body(f"toes_{s}") for s in SIDES if f"toes_{s}" in human.body_names}
        sites = contact_sites(human)
        self.points = {
            side: SitePoints(human, [s for s in sites if s.side == side]) for side in SIDES
        }

    def bodies(self) -> tuple[int, ...]:
        """Return the bodies that may carry a load, right side first."""
        found: list[int] = []
        for side in SIDES:
            if self.feet == "multi-segment":
                found += [int(b) for b in np.unique(self.points[side].body)]
            else:
                found += [self.foot[side], *([self.toes[side]] if side in self.toes else [])]
        return tuple(found)

    def divide(
        self,
        state: BodyState,
        side: str,
        force: Float[Array, " 3"],
        point: Float[Array, " 3"],
        torque: Float[Array, " 3"],
    ) -> list[SegmentLoad]:
        """Return the loads on the segments of a foot, whose sum is the given wrench.

        The wrench is a ground reaction [N] at its centre of pressure [m] with a free moment [N m].
        """
        body = self.foot[side]
        if self.feet == "two-segment":
            toes = self.toes[side]
            forward = state.rotation(body)[:2, 0]
            if (point - state.origin(toes))[:2] @ forward > 0:
                body = toes
        elif self.feet == "multi-segment":
            return self._share(state, side, force, point, torque)
        return [SegmentLoad(body, force, point, torque)]

    def _share(self, state, side, force, point, torque) -> list[SegmentLoad]:
        places = state.position(self.points[side]).copy()
        places[:, 2] -= self.points[side].radius
        share = load_shares(places, point)
        loads = []
        rest = np.array(torque, dtype=float)
        bodies = self.points[side].body
        for body in np.unique(bodies):
            mine = bodies == body
            part = share[mine].sum()
            if part < 1e-6:
                continue
            at = (share[mine] @ places[mine]) / part
            loads.append(SegmentLoad(int(body), part * force, at, part * np.asarray(torque)))
            rest -= part * np.asarray(torque)
            rest -= np.cross(at - point, part * force)
        rest_force = force - sum(load.force for load in loads)
        largest = max(range(len(loads)), key=lambda k: np.linalg.norm(loads[k].force))
        load = loads[largest]
        rest -= np.cross(load.point - point, rest_force)
        loads[largest] = SegmentLoad(
            load.body, load.force + rest_force, load.point, load.torque + rest
        )
        return loads


def segment_forces(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    force: Float[Array, "n_frames 2 3"],
    point: Float[Array, "n_frames 2 3"],
    torque: Float[Array, "n_frames 2 3"],
) -> SegmentForces:
    """Return the ground reactions on each segment over a motion.

    Args:
        force: Ground reaction on each foot, in the order of :data:`SIDES` [N].
        point: Centre of pressure [m]; NaN for an unloaded foot.
        torque: Free moment [N m].
    """
    loads = SegmentLoads(human)
    column = {body: i for i, body in enumerate(loads.bodies())}
    n, k = len(qpos), len(column)
    out = SegmentForces(
        tuple(human.body_names[b - 1][-1] for b in column),
        tuple(human.body_names[b - 1][:-2] for b in column),
        np.zeros((n, k, 3)),
        np.full((n, k, 3), np.nan),
        np.zeros((n, k, 3)),
    )
    for f, state in enumerate(sweep(human, qpos)):
        for side, foot_force, foot_point, foot_torque in zip(
            SIDES, force[f], point[f], torque[f], strict=True
        ):
            if not np.isfinite(foot_point).all():
                continue
            for load in loads.divide(state, side, foot_force, foot_point, foot_torque):
                i = column[load.body]
                out.force[f, i], out.torque[f, i] = load.force, load.torque
                out.point[f, i] = load.point
    return out


def load_shares(
    places: Float[Array, "n_points 3"], point: Float[Array, " 3"]
) -> Float[Array, " n_points"]:
    """Return the share of a load at ``point`` that each contact point carries; the sum is one.

    Args:
        places: Contact points [m].
        point: Centre of pressure [m].
    """
    from scipy.optimize import nnls

    height = places[:, 2] - places[:, 2].min()
    root_weight = np.exp(-0.5 * np.minimum(height / HEIGHT_SCALE, 20.0))
    arm = (places[:, :2] - point[:2]) / 0.1
    stiff = 1e3
    balance = stiff * np.vstack([np.ones(len(places)), arm.T]) * root_weight
    system = np.vstack([balance, np.eye(len(places))])
    right = np.zeros(len(system))
    right[0] = stiff
    share = nnls(system, right)[0] * root_weight
    return share / share.sum()
