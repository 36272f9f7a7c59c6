r"""Scale a person to markers: lengths, marker positions and poses in one least-squares problem.

Over a choice of frames :math:`f`, markers :math:`i`, lengths :math:`\ell_k` and marker places
:math:`b_i` (in their bodies),

.. math:: \min_{q_f,\, \ell,\, b} \;
    \sum_{f,i} \frac{\lVert x_{fi} - x_i(q_f, \ell, b_i) \rVert^2}{\sigma^2}
    + \sum_i \frac{\lVert b_i - b_i(\ell) \rVert^2}{s_i^2}
    + \sum_k \frac{(\ln \ell_k / \ell_k^0)^2}{s_\ell^2}

by Gauss-Newton, the poses eliminated frame by frame (Schur complement), the joint limits kept.
The positions start from the landmarks of :mod:`plantigrade.models.landmarks`, with a standard
deviation :math:`s_i` by their kind, the lengths from stature and sex. Markers of unknown name are
attached to the segment to which their distances are constant, once the known ones give the pose
(:mod:`plantigrade.kinematics.unknown_markers`).

There are five additions. Frames of one trial are not independent, so the marker term of all of them
together counts as :data:`INDEPENDENT_FRAMES`. In a standing trial knees and feet are pulled to
zero; hips and trunk are not, since people stand with the pelvis they have. The iliac spines define
the pelvis, as in every clinical model, so their places in it are trusted to :data:`SPINE_SPREAD`,
and the lumbar joint lies behind the hips where a regression puts it
(:func:`plantigrade.models.anatomy.usual_lumbar_depth`) within :data:`LUMBAR_SPREAD`. And the knee's
axis passes through the epicondyles within :data:`EPICONDYLE_SPREAD`; segment lengths adapt.
A knee straighter than :data:`STRAIGHT_KNEE` is pulled back to it, strongly where no marker on them
was recorded: this sets where the knee's zero lies, so a person who really walks on overstretched
knees comes out some degrees too bent all through (the shape of the curve is not touched).
"""

import copy
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import mujoco
import numpy as np
from scipy.linalg import block_diag

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.inverse import InverseKinematics, bounded_step
from plantigrade.kinematics.posture_prior import PosturePrior
from plantigrade.kinematics.state import PointSet, integrate, sweep
from plantigrade.kinematics.unknown_markers import segment_of
from plantigrade.kinematics.unmeasured_joints import bodies_of
from plantigrade.models import Dimensions, Human
from plantigrade.models.anatomy import usual_lumbar_depth
from plantigrade.models.landmarks import BONE_SPREAD, JOINT_CENTRE_SPREAD, Attachment, attachments
from plantigrade.models.markers import side_of
from plantigrade.side_names import split_side

NOISE = 0.008  # [m] standard deviation of a marker on bone, from skin motion and measurement
# [1] multiple of NOISE for markers on soft tissue, which moves most at thigh and upper arm
# [Leardini2005]_
SOFT_TISSUE_FACTORS = {"femur_r": 2.0, "femur_l": 2.0, "humerus_r": 2.0, "humerus_l": 2.0}
# [1] multiple of NOISE for markers on the pelvis. The iliac spines define its orientation; the more
# numerous leg markers depend on it through hip joint centres with errors of a centimetre, one-axis
# knees and the skin of the thigh. With equal weights they tilt it by 2° to 3° in every stride.
BONE_FACTORS = {"pelvis": 0.4}
# [1] effective number of independent frames; skin motion repeats in every stride
INDEPENDENT_FRAMES = 6
LENGTH_SPREAD = 0.10  # [1] SD of the logarithm of a length about its share of stature
# [1] the same about a length between joint centres in a video. Without it, noise lengthens bones: a
# leg that is too long can bend, one that is too short cannot reach.
SEEN_LENGTH_SPREAD = 0.01
LUMBAR_SPREAD = 0.006  # [m] SD of the lumbar joint about its regression
# [m] SD of the iliac spines in the pelvis along x and z; small because they define the pelvis. The
# width between them has BONE_SPREAD.
SPINE_SPREAD = 0.003
# [m] SD of a common shift of the spines relative to the hip joint centres, the error of the
# regression
HIP_SPREAD = 0.008
# SD along the thigh of an epicondyle marker about the knee axis, the error of palpation
# [DellaCroce2005]_. The skin slides backwards by about 20 mm per radian of knee flexion
# [Leardini2005]_, which would bias the axis by as much downwards if the motion determined it.
EPICONDYLE_SPREAD = 0.006  # [m]
HEIGHT_SPREAD = 0.012  # [m] SD of a given stature
FREE_SPREAD = 0.5  # [m] SD of a marker with unknown position
POSTURE_SPREAD = 1.5  # [rad] SD of a hinge about standing
# [rad] SD of head and neck about upright; a head band has an arbitrary angle
NECK_SPREAD = 0.15
STANDING_SPREAD = 0.10  # [rad] SD of these coordinates about zero in a standing trial
# Without a marker on an epicondyle, marker positions and knee angle are not independent; knees are
# therefore pulled back to a minimum flexion during calibration.
STRAIGHT_KNEE = 0.07  # [rad] minimum knee flexion
STRAIGHT_SPREAD = 0.012  # [rad] SD of straighter knees without an epicondyle marker
BELT_LANDMARKS = {"front": {"asis"}, "back": {"psis", "sacrum"}}  # landmarks replaced by a belt
# SD of straighter knees with such a marker, which locates the axis within a centimetre
KNOWN_SPREAD = 0.03  # [rad]
# sum to stature
STATURE_LENGTHS = ("ankle_height", "shank", "thigh", "pelvis_height", "trunk", "head")
_EPICONDYLES = ("knee_lateral", "knee_medial")
_STANDING = ("hip_adduction", "hip_rotation", "lumbar_bending", "lumbar_rotation")
_STANDING += ("knee_", "ankle_", "subtalar_", "mtp", "cuboid_", "heel_")


def noise_factor(place: Attachment | None) -> float:
    """Return the noise of a marker relative to a marker on bone [1]."""
    if place is None:
        return 1.0
    return BONE_FACTORS.get(
        place.body, SOFT_TISSUE_FACTORS.get(place.body, 1.0) if place.spread > BONE_SPREAD else 1.0
    )


class Calibrator:
    """State of the joint least-squares problem of :func:`calibrate`."""

    def __init__(
        self,
        human: Human,
        names: Sequence[str],
        landmarks: dict[str, Attachment | None],
        measured: Float[Array, "n_frames n_markers 3"],
        *,
        height: float | None,
        standing: Bool[Array, " n_frames"],
        prior: PosturePrior | None = None,
    ):
        self.human, self.names = human, list(names)
        self.places: list[Attachment | None] = [landmarks[n] for n in names]
        self.measured = measured
        self.height, self.prior = height, prior
        self.start = human.dimensions.as_array()
        self.log_lengths = np.zeros(len(self.start))
        self.offsets = np.zeros((len(names), 3))
        self.qpos = np.tile(human.standing(), (len(measured), 1))
        table = attachments(human)
        by_place = {(a.body, tuple(a.position)): name for name, a in table.items()}
        # The landmark each place came from, to follow it when lengths change.
        self.landmark_names = [
            by_place.get((p.body, tuple(p.position))) if p else None for p in self.places
        ]
        straight = np.array([c.startswith(_STANDING) for c in human.coordinates])
        spread = np.full((len(measured), len(straight)), POSTURE_SPREAD)
        spread[:, ["neck_" in c for c in human.coordinates]] = NECK_SPREAD
        spread[standing[:, None] & straight] = STANDING_SPREAD
        self.rest, self.noise = human.standing()[7:], NOISE
        if prior is not None:
            self.rest, self.noise = prior.rest, max(NOISE, prior.noise)
            spread = np.minimum(spread, prior.spread)
        self.posture_weight = 1 / spread**2
        marks = [split_side(n or "")[0] for n in self.landmark_names]
        # A marker on the sacrum stands for the posterior spines where they have none.
        defining = {"asis", "psis" if "psis" in marks else "sacrum"}
        # Without those, markers on a belt are the best there is.
        defining |= {f"waist_{end}" for end, m in BELT_LANDMARKS.items() if not set(marks) & m}
        self.spines = {i for i, mark in enumerate(marks) if mark in defining}
        self.epicondyles = {i for i, mark in enumerate(marks) if mark in _EPICONDYLES}
        known = [
            f"knee_angle{(name or '')[-2:]}"
            for name, mark, place in zip(self.landmark_names, marks, self.places, strict=True)
            if mark in _EPICONDYLES
            or (mark == "knee_joint" and place and place.spread <= JOINT_CENTRE_SPREAD)
        ]
        self.knees = np.array([c.startswith("knee_angle") for c in human.coordinates])
        spread = [KNOWN_SPREAD if c in known else STRAIGHT_SPREAD for c in human.coordinates]
        self.straight = np.array(spread) if prior is None else np.full(len(spread), np.inf)

    def start_from_seen_lengths(self) -> None:
        """Start from the lengths that a video shows, where there is one."""
        for name, length in ({} if self.prior is None else self.prior.lengths).items():
            self.start[Dimensions.names().index(name)] = length

    @property
    def dimensions(self) -> Dimensions:
        """The current lengths [m]."""
        return Dimensions.from_array(self.start * np.exp(self.log_lengths))

    def geometry(self, d: Dimensions) -> tuple[np.ndarray, np.ndarray]:
        """Return body offsets and marker places (without refinements) for lengths ``d`` [m]."""
        table = attachments(self.human, d)
        places = [
            table[name].position if name else (p.position if p else np.zeros(3))
            for name, p in zip(self.landmark_names, self.places, strict=True)
        ]
        return self.human.body_positions(d), np.array(places)

    def known(self) -> np.ndarray:
        """Return the indices of attached markers."""
        return np.array([i for i, p in enumerate(self.places) if p is not None], dtype=int)

    def points(self, which: np.ndarray) -> PointSet:
        """Return the markers ``which`` on the body with the current lengths and places."""
        bodies, base = self.geometry(self.dimensions)
        places = [p for p in (self.places[i] for i in which) if p is not None]
        local = (base + self.offsets)[which]
        return PointSet(self.human, [p.body for p in places], local, _resized(self.human, bodies))

    def solve_poses(self) -> np.ndarray:
        """Solve every frame's pose with fixed lengths and positions; return the residuals [m]."""
        which = self.known()
        places = [p for p in self.places if p is not None]
        weights = np.array([min(1.0, (0.02 / p.spread) ** 2) for p in places])
        solver = InverseKinematics(self.points(which), weights, tolerance=1e-4)
        if self.prior is not None:
            self.prior.set_on(solver)
        residual = np.full(self.measured.shape[:2], np.nan)
        for f in range(len(self.measured)):
            solution = solver.solve(self.measured[f, which], self.qpos[f])
            self.qpos[f] = solution.qpos
            residual[f, which] = solution.residual
        return residual

    def refine(self) -> float:
        """Take one joint Gauss-Newton step; return the root-mean-square marker error [m]."""
        which = self.known()
        lengths = self.dimensions.as_array()
        d_bodies, d_base = (slope * lengths[:, None, None] for slope in self._slopes)
        points = self.points(which)
        n_l, n_m, nv = len(lengths), len(which), points.model.nv
        n_p = n_l + 3 * n_m
        H, g = np.zeros((n_p, n_p)), np.zeros(n_p)
        steps = []
        noise = self.noise * np.array([noise_factor(self.places[i]) for i in which])
        evidence = min(1.0, INDEPENDENT_FRAMES / len(self.measured))
        total, count = 0.0, 0
        low, high = self.human.limits
        for f, state in enumerate(sweep(self.human, self.qpos, model=points.model)):
            target = self.measured[f, which]
            seen = np.isfinite(target[:, 0])
            error = np.where(seen[:, None], target - points.values(state), 0.0)
            distance = np.linalg.norm(error, axis=1)
            # Huber: a distant marker (swapped, outlier) has the weight of five standard deviations
            w = seen * np.minimum(1.0, 5 * noise / np.maximum(distance, 1e-9)) / noise**2
            w *= evidence
            root_w = np.sqrt(np.repeat(w, 3))
            J = points.jacobian(state).reshape(-1, nv) * root_w[:, None]
            rotation = state.rotations
            L = self._length_jacobian(points, rotation, d_bodies, d_base[:, which])
            L = L.reshape(-1, n_l) * root_w[:, None]
            R = rotation[points.body]
            r = error.ravel() * root_w
            A = J.T @ J
            A[np.arange(6, nv), np.arange(6, nv)] += evidence * self.posture_weight[f]
            bent_back = self.knees & (self.qpos[f, 7:] < STRAIGHT_KNEE)
            pull = 1 / self.straight[bent_back] ** 2
            A[6:, 6:][bent_back, bent_back] += pull
            A.flat[:: nv + 1] += 1e-6 * A.trace() / nv
            gq = J.T @ r
            gq[6:] += evidence * (self.rest - self.qpos[f, 7:]) * self.posture_weight[f]
            gq[6:][bent_back] += (STRAIGHT_KNEE - self.qpos[f, 7:][bent_back]) * pull
            # Offsets: block diagonal, each marker's rotation times its root weight.
            P = np.hstack([L, np.asarray(block_diag(*(R * np.sqrt(w)[:, None, None])))])
            C = J.T @ P
            X = np.linalg.solve(A, np.column_stack([C, gq]))
            H += P.T @ P - C.T @ X[:, :-1]
            g += P.T @ r - C.T @ X[:, -1]
            steps.append((A, gq, C))
            total += float((distance[seen] ** 2).sum())
            count += int(seen.sum())
        self._add_priors(H, g, which, lengths)
        step = np.linalg.solve(H + 1e-9 * np.eye(n_p), g)
        biggest = np.abs(step[:n_l]).max()
        if biggest > 0.1:
            step *= 0.1 / biggest
        self.log_lengths += step[:n_l]
        self.offsets[which] += step[n_l:].reshape(-1, 3)
        for f, (A, gq, C) in enumerate(steps):
            d = bounded_step(A, gq - C @ step, low - self.qpos[f, 7:], high - self.qpos[f, 7:])
            shorter = min(1.0, 0.5 / max(np.abs(d).max(), 1e-9))
            self.qpos[f] = integrate(points.model, self.qpos[f], d * shorter)
            self.qpos[f, 7:] = np.clip(self.qpos[f, 7:], low, high)
        return float(np.sqrt(total / max(count, 1)))

    @cached_property
    def _slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """Change of body offsets and marker places per length; the geometry is linear in them."""
        bodies, places = self.geometry(Dimensions.from_array(self.start))
        changed = self.start + 0.01 * np.eye(len(self.start))
        there = [self.geometry(Dimensions.from_array(values)) for values in changed]
        d_bodies, d_places = [b - bodies for b, _ in there], [p - places for _, p in there]
        return np.array(d_bodies) / 0.01, np.array(d_places) / 0.01

    @staticmethod
    def _length_jacobian(points, rotation, d_bodies, d_base) -> np.ndarray:
        """Return d position / d log length, (n_markers, 3, n_lengths)."""
        parent = points.model.body_parentid
        n_bodies = points.model.nbody
        # Movement of each body's origin: its parent's movement plus the turned change of offset.
        moved = np.zeros((n_bodies, len(d_bodies), 3))
        for body in range(2, n_bodies):
            moved[body] = moved[parent[body]] + d_bodies[:, body - 1] @ rotation[parent[body]].T
        own = np.einsum("mij,kmj->mki", rotation[points.body], d_base)
        return (moved[points.body] + own).transpose(0, 2, 1)

    def _add_priors(self, H, g, which, lengths) -> None:
        n_l = len(lengths)
        k = np.arange(n_l)
        d, depth = self.dimensions, Dimensions.names().index("lumbar_depth")
        inverse = np.full(n_l, 1 / LENGTH_SPREAD**2)
        inverse[depth] = (lengths[depth] / LUMBAR_SPREAD) ** 2
        for name in () if self.prior is None else self.prior.lengths:
            inverse[Dimensions.names().index(name)] = 1 / SEEN_LENGTH_SPREAD**2
        away = self.log_lengths.copy()
        away[depth] = 1 - usual_lumbar_depth(d) / d.lumbar_depth
        H[k, k] += inverse
        g[:n_l] -= away * inverse
        if self.height is not None:
            slope = np.where([name in STATURE_LENGTHS for name in Dimensions.names()], lengths, 0.0)
            H[:n_l, :n_l] += np.outer(slope, slope) / HEIGHT_SPREAD**2
            g[:n_l] += slope * (self.height - self.dimensions.height) / HEIGHT_SPREAD**2
        spines = []
        for i, marker in enumerate(which):
            place = self.places[marker]
            spread = place.spread if place else FREE_SPREAD
            first = n_l + 3 * i
            spine = marker in self.spines
            s = np.array([first + 1]) if spine else np.arange(first, first + 3)
            spines += [first] if spine else []
            within = np.full(len(s), spread)
            if marker in self.epicondyles:
                within[2] = EPICONDYLE_SPREAD
            H[s, s] += 1 / within**2
            g[s] -= self.offsets[marker][s - first] / within**2
        offsets = self.offsets[which].ravel()
        for axis in (0, 2):
            s = np.array(spines, dtype=int) + axis
            apart = SPINE_SPREAD**2 * np.eye(len(s)) + HIP_SPREAD**2
            inverse = np.linalg.inv(apart)
            H[np.ix_(s, s)] += inverse
            g[s] -= inverse @ offsets[s - n_l]

    def attach_unknown(self) -> dict[str, str]:
        """Put markers without a place on the segment to which their distances are constant.

        An arm without markers takes none, because it hangs next to the hip and would otherwise
        carry markers of the pelvis.
        """
        bodies, _ = self.geometry(self.dimensions)
        states = sweep(self.human, self.qpos, model=_resized(self.human, bodies))
        poses = [(state.origins, state.rotations) for state in states]
        origins, rotations = (np.array([pose[k] for pose in poses]) for k in (0, 1))
        names = self.human.body_names
        on = [p.body for p in self.places if p is not None]
        unseen = {
            body
            for side in SIDES
            if not (arm := bodies_of(self.human, [f"arm_flex_{side}"])) & set(on)
            for body in arm
        }
        frames = {
            name: (origins[:, b], rotations[:, b])
            for b, name in enumerate(names, start=1)
            if name not in unseen
        }
        which = self.known()
        table = attachments(self.human, self.dimensions)
        marks = [mark for name, mark in table.items() if "_joint_" not in name]  # on the skin
        attached = {}
        for i, place in enumerate(self.places):
            marker = self.measured[:, i]
            if place is None and np.isfinite(marker[:, 0]).sum() >= 3:
                side = side_of(self.names[i], self.names)
                found = segment_of(marker, self.measured[:, which], on, frames, marks, side)
                if found is not None:
                    self.places[i] = replace(found, spread=FREE_SPREAD)
                    attached[self.names[i]] = found.body
        return attached


def _resized(human: Human, bodies: Float[Array, "n_bodies 3"]) -> mujoco.MjModel:
    """Return a copy of the model with new offsets between bodies and unchanged masses."""
    model = copy.deepcopy(human.model)
    model.body_pos[2:] = bodies[1:]
    return model
