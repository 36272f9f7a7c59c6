r"""Which segments of a foot carry a measured ground reaction.

A plate measures one wrench per foot; how segments share it cannot be measured. The joints above
the foot do not depend on the choice, the joints within it do.

* ``rigid``: the foot.
* ``two-segment``: the toes where the centre of pressure lies ahead of the toe joint, else the
  hindfoot, as is usual [Stefanyshyn1997]_; the moment of the toe joint then starts from (almost)
  no lever arm.
* ``multi-segment``: every contact point :math:`i` carries the part :math:`s_i \ge 0` of the force,
  chosen so that :math:`\sum s_i = 1` and :math:`\sum s_i p_i` is the centre of pressure, with the
  least :math:`\sum s_i^2 / w_i`; :math:`w_i = \exp(-h_i / h_0)` falls with the height of the point
  above the lowest one. What no share can give (a centre of pressure outside the sole) is added
  as a moment on the segment with the largest share, so that the sum is what was measured.

References:
    [Stefanyshyn1997]_.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import State, sweep
from plantigrade.models import Human

SOFTNESS = 0.01  # height above the lowest point at which a point's readiness falls to 1/e [m]


@dataclass(frozen=True)
class SegmentLoad:
    """What one body carries: a force at a point and a torque, world axes."""

    body: int  #: Index of the body in the model
    force: Float[Array, " 3"]  #: Force [N]
    point: Float[Array, " 3"]  #: Where it acts [m]
    torque: Float[Array, " 3"]  #: Torque [N m]


@dataclass(frozen=True)
class SegmentForces:
    """What each segment of the feet carries over a motion."""

    side: tuple[str, ...]  #: ``"r"`` or ``"l"`` of each segment
    segment: tuple[str, ...]  #: Its name without the side: body ``{segment}_{side}`` of the model
    force: Float[Array, "n_frames n_segments 3"]  #: Force, world [N]; zero where it carries none
    #: Where it acts, world [m]; NaN where it carries none
    point: Float[Array, "n_frames n_segments 3"]
    torque: Float[Array, "n_frames n_segments 3"]  #: Torque at that point, world [N m]


class Carriers:
    """Divides ground reactions over the segments of one person's feet."""

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
        state: State,
        side: str,
        force: Float[Array, " 3"],
        point: Float[Array, " 3"],
        torque: Float[Array, " 3"],
    ) -> list[SegmentLoad]:
        """Return what each segment of a foot carries; the sum is what was given.

        That is the ground reaction [N] at its centre of pressure [m] with a free moment [N m].
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
        share = shares(places, point)
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
    """Return ground reactions by the segments that carry them, over a motion.

    Args:
        human: Whose motion.
        qpos: Configurations.
        force: Ground reaction on each foot, in the order of :data:`SIDES` [N].
        point: Its centre of pressure [m]; NaN where the foot carries none.
        torque: Its free moment [N m].
    """
    carriers = Carriers(human)
    column = {body: i for i, body in enumerate(carriers.bodies())}
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
            for load in carriers.divide(state, side, foot_force, foot_point, foot_torque):
                i = column[load.body]
                out.force[f, i], out.torque[f, i] = load.force, load.torque
                out.point[f, i] = load.point
    return out


def shares(
    places: Float[Array, "n_points 3"], point: Float[Array, " 3"]
) -> Float[Array, " n_points"]:
    """Return the part of a load at ``point`` that each contact point carries; adds up to one.

    Args:
        places: Contact points [m].
        point: Centre of pressure [m].
    """
    from scipy.optimize import nnls

    height = places[:, 2] - places[:, 2].min()
    root_weight = np.exp(-0.5 * np.minimum(height / SOFTNESS, 20.0))
    arm = (places[:, :2] - point[:2]) / 0.1
    stiff = 1e3
    balance = stiff * np.vstack([np.ones(len(places)), arm.T]) * root_weight
    system = np.vstack([balance, np.eye(len(places))])
    wanted = np.zeros(len(system))
    wanted[0] = stiff
    share = nnls(system, wanted)[0] * root_weight
    return share / share.sum()
