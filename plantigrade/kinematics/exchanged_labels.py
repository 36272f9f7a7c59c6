r"""Detection of labels exchanged throughout a recording, by anatomy and rigidity.

Seen along the direction a person faces, the vector :math:`e` from one landmark to another is known
where both are on one segment of pelvis, trunk, head, legs or feet, or are the same point of the
left and the right: a knee is to the right of the other, the forehead in front of the occiput. With
:math:`m` the same vector as recorded, middle of all frames,

.. math:: \rho = \frac{m \cdot e}{\lVert e \rVert^2}

is near 1 where the labels are right and near -1 where they are exchanged; walking, running, squats
and jumps leave it above 0. Exchanging two labels lowers the squared distance to the standing body
by :math:`-2 m \cdot e`. The exchange with the largest decrease comes first: two labels, a limb and
its twin, or those of a segment by the best assignment; it is accepted only if inverse kinematics
with usual proportions agrees. The medial markers of the two knees pass close to each other and are
distinguished by constant distances to the markers of their limb.

A mirrored person has left and right exchanged but the toes in front, which is impossible for any
pose. The search is repeated for the mirror image of the markers. With the residual :math:`d` of
inverse kinematics and the share :math:`s` of exchanged labels, the recording is mirrored if its
mirror image has a much smaller :math:`d\,(1 + s)`. Backward walking is not affected, because each
frame is examined separately and heels, toes, knees and pelvis agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from plantigrade.arrays import Array, Bool, Float, spread
from plantigrade.errors import FitError
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.sides import mirrored
from plantigrade.kinematics.standing_poses import standing_poses
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import BONE_SPREAD, Attachment
from plantigrade.models.parts import MIRROR
from plantigrade.motion import Markers
from plantigrade.motion.distances import distances
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import about_vertical

TRUNK_BODIES = {"pelvis", "abdomen", "torso", "lower_thorax", "thorax", "clavicle_r", "clavicle_l"}
# bodies that rotate freely about their length
ARM_BODIES = ("humerus", "forearm", "ulna", "radius", "hand", "fingers")
ANATOMY_FRAMES = 24  # [1] frames for the anatomical test
CONFIRMATION_FRAMES = 6  # [1] frames for the confirmation by inverse kinematics
MIN_TRUNK_MARKERS = 6  # [1] number of trunk markers that determine the heading without the legs
MAX_EXCHANGED_RHO = -0.5  # [1] maximum rho of exchanged labels
MIN_LANDMARK_DISTANCE = 0.05  # [m] minimum distance of distinguishable landmarks
# [1] maximum rho of all markers of an exchanged limb; runners step on one line
MAX_EXCHANGED_LIMB_RHO = -0.3
# [1] maximum ratio of the labelling costs of the mirror image and the recording for a mirrored
# recording. Mirrored recordings have 0.2 to 0.6, 0.75 without markers on knees and ankles;
# exchanged labels of both legs give 0.85.
MAX_MIRRORED_RATIO = 0.78
MIN_EXCHANGE_GAIN = 0.02  # [1] minimum decrease of the error relative to the labels' distance
MAX_SPREAD_RATIO = 0.5  # [1] maximum spread ratio (other leg over own leg) of an exchanged marker
MIN_LIMB_SPREAD = 0.03  # [m] minimum spread of an exchanged marker on its own leg
_YAWS = np.deg2rad(np.arange(0, 360, 5))


@dataclass(frozen=True)
class Landmarks:
    """Markers with known positions on a standing person."""

    human: Human  #: The person
    names: tuple[str, ...]  #: Marker names
    places: tuple[Attachment, ...]  #: Attachment of each marker

    @property
    def standing(self) -> Float[Array, "n_markers 3"]:
        """Positions on the standing person facing x [m]."""
        return PointSet.of(self.human, list(self.places)).path(self.human.standing()[None])[0]


@dataclass(frozen=True)
class Exchange:
    """Exchanged labels."""

    recorded_as: dict[str, str]  #: Label → the different label under which its marker was recorded

    @classmethod
    def of(cls, names: Sequence[str], order: np.ndarray) -> "Exchange":
        """Return the exchange with the marker of each label in column ``order``."""
        taken = {name: str(names[k]) for name, k in zip(names, order, strict=True)}
        return cls({name: own for name, own in taken.items() if name != own})

    def __bool__(self) -> bool:
        """Return whether any label is exchanged."""
        return bool(self.recorded_as)

    @property
    def cycles(self) -> list[tuple[str, ...]]:
        """Cycles of exchanged labels, mostly pairs."""
        found, left = [], dict(sorted(self.recorded_as.items()))
        while left:
            name = next(iter(left))
            cycle = []
            while name in left:
                cycle.append(name)
                name = left.pop(name)
            found.append(tuple(cycle))
        return found

    def undone(self, markers: Markers) -> Markers:
        """Return the markers with corrected labels."""
        columns = [markers.index(self.recorded_as.get(name, name)) for name in markers.names]
        return replace(markers, positions=markers.positions[:, columns])


def exchanged_by_anatomy(
    known: Landmarks, samples: Float[Array, "n_frames n_markers 3"], source: object
) -> Exchange:
    """Return the labels whose exchange makes the markers those of a person.

    Args:
        samples: Recorded positions [m]; NaN if not visible.
    """
    usual = _with_their_limb(known, distances(samples).spread)
    frames = samples[np.isfinite(samples[..., 0]).sum(axis=1) >= min(6, len(usual))]
    if len(frames):
        frames = frames[spread(len(frames), ANATOMY_FRAMES)]
        frames = _head_up(frames, known.standing)
        order, cost = _labelling(known, frames, usual)
        if _labelling(known, frames * MIRROR, usual)[1] < MAX_MIRRORED_RATIO * cost:
            raise FitError(mirrored(source))
        usual = order
    return Exchange.of(known.names, usual)


def _head_up(
    frames: Float[Array, "n_frames n 3"], standing: Float[Array, "n 3"]
) -> Float[Array, "n_frames n 3"]:
    """Return the frames with upside-down persons turned upright; a fit starts from standing."""
    up = frames[..., 2] - np.nanmean(frames[..., 2], axis=1, keepdims=True)
    upside_down = np.nansum(up * (standing[:, 2] - standing[:, 2].mean())) < 0
    return frames * [1.0, -1.0, -1.0] if upside_down else frames


def _labelling(
    known: Landmarks, frames: Float[Array, "n_frames n_markers 3"], usual: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return the column of each label's marker, and the cost [m].

    The cost is the mean distance to the nearest pose of a person of usual proportions, times one
    plus the share of the labels that are exchanged.
    """
    some = frames[spread(len(frames), CONFIRMATION_FRAMES)]
    height = known.human.height * _scale(known, frames)
    h = known.human
    human = Human.create(float(np.clip(height, 0.6, 2.4)), h.mass, h.sex, h.joints, h.feet)
    here, order = some[:, usual], _as_a_person_stands(known, frames, usual)
    errors = _errors(human, known.places, here)
    moved = order != usual
    if moved.any():
        there = some[:, order]
        gain = errors - (exchanged := _errors(human, known.places, there))
        if np.nansum(gain) > MIN_EXCHANGE_GAIN * np.nansum(np.linalg.norm(here - there, axis=-1)):
            return order, float(np.nanmean(exchanged)) * (1 + moved.mean())
    return usual, float(np.nanmean(errors))


def _as_a_person_stands(
    known: Landmarks, frames: Float[Array, "n_frames n_markers 3"], order: np.ndarray
) -> np.ndarray:
    """Return the column of each label's marker that best matches the standing person."""
    standing = known.standing
    standing = standing * _scale(known, frames)
    trunk = np.array([p.body in TRUNK_BODIES for p in known.places], dtype=bool)
    e = standing[:, None] - standing
    length2 = np.maximum((e**2).sum(axis=-1), 1e-12)
    twins = np.triu(_twins(known))
    rigid = np.triu(_comparable(known) & (length2 >= MIN_LANDMARK_DISTANCE**2))
    moves = [np.array([pair]) for pair in np.argwhere(rigid)]
    limb = _limbs(known)
    moves += [pairs for b in sorted({*limb}) if len(pairs := _of_limb(twins, limb == b)) > 1]
    least = np.array(
        [MAX_EXCHANGED_RHO if len(pairs) == 1 else MAX_EXCHANGED_LIMB_RHO for pairs in moves]
    )
    groups = [np.flatnonzero(limb == b) for b in sorted({*limb}) if not b.startswith(ARM_BODIES)]
    new = np.arange(len(order))
    for _ in known.names:
        now = _facing_x(frames[:, order[new]], standing, trunk)
        m = now[:, :, None] - now[:, None]
        dot = _median(np.einsum("fijk,ijk->fij", m, e))
        gains = np.array([-dot[tuple(pairs.T)].sum() for pairs in moves])
        sizes = np.array([length2[tuple(pairs.T)].sum() for pairs in moves])
        gains[~(gains > -least * sizes)] = 0.0
        other = new.copy()
        if gains.max(initial=0.0) > 0:
            for i, j in moves[gains.argmax()]:
                other[[i, j]] = other[[j, i]]
        for group in groups:
            taken, gain = _as_a_segment_stands(now[:, group], standing[group])
            if gain > gains.max(initial=0.0):
                gains, other = np.array([gain]), new.copy()
                other[group] = new[group[taken]]
        if (other == new).all():
            break
        new = other
    return order[new]


def _as_a_segment_stands(
    x: Float[Array, "n_frames n 3"], standing: Float[Array, "n 3"]
) -> tuple[np.ndarray, float]:
    """Return the column of each label of a segment by the best assignment, and its gain [m²].

    Parts of the assignment that exchange close landmarks, or gain less than opposite labels, are
    ignored.
    """
    none = np.arange(len(standing))
    whole = x[np.isfinite(x[..., 0]).all(axis=1)]
    if len(none) < 2 or not len(whole):
        return none, 0.0
    p = standing - standing.mean(axis=0)
    similarity = np.median(
        (whole - whole.mean(axis=1, keepdims=True)) @ p.T, axis=0
    )  # column, label
    labels, columns = linear_sum_assignment(-similarity.T)
    taken, total = none.copy(), 0.0
    left = {int(k) for k in labels[labels != columns]}
    while left:
        cycle = [left.pop()]
        while (after := int(columns[cycle[-1]])) != cycle[0]:
            cycle.append(after)
            left.discard(after)
        to = columns[cycle]
        gain = float((similarity[to, cycle] - similarity[cycle, cycle]).sum())
        apart2 = ((p[cycle] - p[to]) ** 2).sum(axis=1)
        if (
            gain > -MAX_EXCHANGED_RHO * apart2.sum() / 2
            and apart2.min() >= MIN_LANDMARK_DISTANCE**2
        ):
            taken[cycle], total = to, total + gain
    return taken, total


def _limbs(known: Landmarks) -> np.ndarray:
    """Return the limb segment of each marker; foot and toes count as one."""
    limbs = ("pelvis", "femur", "tibia", "humerus", "forearm", "hand")
    bodies = [p.body for p in known.places]
    foot = [
        b.endswith(("_r", "_l")) and not b.startswith((*limbs, *ARM_BODIES, "clav")) for b in bodies
    ]
    return np.array([f"foot{b[-2:]}" if f else b for b, f in zip(bodies, foot, strict=True)])


def _of_limb(twins: Bool[Array, "n n"], on_it: Bool[Array, " n"]) -> np.ndarray:
    """Return the twins with one marker on a limb segment, (n_pairs, 2)."""
    return np.argwhere(twins & (on_it[:, None] | on_it))


def _with_their_limb(known: Landmarks, spread: Float[Array, "n n"]) -> np.ndarray:
    """Return the columns with every marker on the limb with constant distances."""
    order = np.arange(len(known.names))
    for _ in known.names:
        pair = _on_the_other_limb(known, spread[np.ix_(order, order)])
        if pair is None:
            break
        order[[*pair]] = order[[*pair[::-1]]]
    return order


def _on_the_other_limb(known: Landmarks, spread: Float[Array, "n n"]) -> tuple[int, int] | None:
    """Return two twins with constant distances to the other limb's markers instead of their own.

    The medial knee markers of a walking person pass so close that only this test separates them.
    """
    body = _limbs(known)
    best, worst = None, MIN_LIMB_SPREAD
    for i, j in np.argwhere(np.triu(_twins(known))):
        here, there = np.flatnonzero(body == body[i]), np.flatnonzero(body == body[j])
        here, there = here[here != i], there[there != j]
        if not len(here) or not len(there):
            continue
        own = _usual(spread[i, here]) + _usual(spread[j, there])
        other = _usual(spread[i, there]) + _usual(spread[j, here])
        if own > worst and other < MAX_SPREAD_RATIO * own:
            best, worst = (int(i), int(j)), own
    return best


def _usual(spread: Float[Array, " n"]) -> float:
    """Return the median of the known spreads; NaN without any."""
    seen = spread[np.isfinite(spread)]
    return float(np.median(seen)) if len(seen) else float("nan")


def _twins(known: Landmarks) -> Bool[Array, "n n"]:
    """Return the pairs of the same point on the left and the right limb."""
    body = np.array([p.body for p in known.places])
    segment = np.array([split_side(name)[0] for name in body])
    position = np.array([p.position for p in known.places])
    twin = np.abs(position[:, None] * MIRROR - position).max(axis=-1) < 1e-6
    return twin & (segment[:, None] == segment) & (body[:, None] != body)


def _comparable(known: Landmarks) -> Bool[Array, "n_markers n_markers"]:
    """Return the pairs with a known vector, of one segment or of left and right."""
    limb = _limbs(known)
    free = np.array([name.startswith(ARM_BODIES) for name in limb], dtype=bool)
    # on pelvis, trunk and head both sides belong to the same segment
    return _twins(known) | ((limb[:, None] == limb) & ~free)


def _scale(known: Landmarks, frames: Float[Array, "n_frames n 3"]) -> float:
    """Return the size of the recorded person relative to the standing one [1].

    It follows from distances on a segment or to the next one, between points of bone if there are
    any.
    """
    rest = np.linalg.norm(known.standing[:, None] - known.standing, axis=-1)
    seen = distances(frames).usual
    body = np.array([known.human.body(p.body) for p in known.places])
    parent = known.human.model.body_parentid[body]
    near = (body[:, None] == body) | (parent[:, None] == body) | (parent == body[:, None])
    use = near & (rest > 0.15) & np.isfinite(seen)
    bone = np.array([p.spread <= BONE_SPREAD for p in known.places])
    use = on_bone if (on_bone := use & bone & bone[:, None]).any() else use
    return float(np.clip(np.median(seen[use] / rest[use]), 0.4, 1.6)) if use.any() else 1.0


def _facing_x(
    frames: Float[Array, "n_frames n 3"], standing: Float[Array, "n 3"], trunk: Bool[Array, " n"]
) -> Float[Array, "n_frames n 3"]:
    """Return the frames turned about the vertical so that the trunk faces x.

    The direction is that of the smallest mean distance (not squared): a pair of exchanged labels
    does not turn it.
    """
    turned, turns = np.full_like(frames, np.nan), about_vertical(_YAWS)
    for f, frame in enumerate(frames):
        seen = np.isfinite(frame[:, 0])
        use = seen & trunk if (seen & trunk).sum() >= MIN_TRUNK_MARKERS else seen
        a, b = standing[use], frame[use]
        away = b @ turns - a
        away -= np.median(away, axis=1, keepdims=True)
        k = np.linalg.norm(away, axis=-1).mean(axis=1).argmin()
        turned[f] = frame @ turns[k]
    return turned


def _median(values: np.ndarray) -> np.ndarray:
    """Return the median over frames; infinite for a pair that is never visible."""
    ordered = np.sort(values, axis=0)  # NaN come last
    count = np.isfinite(values).sum(axis=0)
    middle = np.take_along_axis(ordered, np.maximum(count - 1, 0)[None] // 2, axis=0)[0]
    return np.where(count > 0, middle, np.inf)


def _errors(human: Human, places: Sequence[Attachment], frames: np.ndarray) -> np.ndarray:
    """Return the marker errors of the nearest pose of a person of usual proportions [m]."""
    solver = InverseKinematics(PointSet.of(human, list(places)), tolerance=1e-3, max_iterations=25)
    starts = standing_poses(human, list(places), frames)
    return np.array([solver.solve(f, q).residual for f, q in zip(frames, starts, strict=True)])
