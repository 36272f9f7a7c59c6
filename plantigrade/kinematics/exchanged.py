r"""Labels that are exchanged through a whole recording, found by anatomy and by rigidity.

Seen along the direction a person faces, the vector :math:`e` from one landmark to another is known
where both are on one segment of pelvis, trunk, head, legs or feet, or are the same point of the
left and the right: a knee is to the right of the other, the forehead in front of the occiput. With
:math:`m` the same vector as recorded, middle of all frames,

.. math:: \rho = \frac{m \cdot e}{\lVert e \rVert^2}

is near 1 where the labels are right and near -1 where they are exchanged; walking, running, squats
and jumps leave it above 0. Exchanging two labels lowers the squared distance to the standing body
by :math:`-2 m \cdot e`. What lowers it most is exchanged first: two labels, a limb and its twin, or
those of a segment by the best assignment; it is believed only if inverse kinematics on usual
proportions agrees. The medial markers of the two knees pass near to each other: there the distances
tell, which are constant to the markers of one's own limb.

A mirrored person has left and right exchanged and yet the toes in front, and no pose of a body does
that. The same search is made on the mirror image of the markers. With the distance :math:`d` that
inverse kinematics leaves and the share :math:`s` of labels to be exchanged, the recording is
mirrored where its mirror image has a much smaller :math:`d\,(1 + s)`. People who walk backwards are
not mirrored: each frame is examined by itself, and their heels, toes, knees and pelvis agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from plantigrade.arrays import Array, Bool, Float
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

TRUNK = {"pelvis", "abdomen", "torso", "lower_thorax", "thorax", "clavicle_r", "clavicle_l"}
FREE = ("humerus", "forearm", "ulna", "radius", "hand", "fingers")  # turn about their length
FRAMES, CONFIRMED_ON = 24, 6  # frames the anatomy is seen in, and inverse kinematics
ENOUGH = 6  # markers of the trunk that tell where it faces, without those of the legs
OPPOSITE, APART = -0.5, 0.05  # rho of exchanged labels; landmarks nearer than this [m] are not told
LIMB_OPPOSITE = -0.3  # rho of all markers of a limb together: runners set their feet on one line
# Cost of the labels in the mirror image over that as recorded, below which a recording is mirrored:
# 0.2 to 0.6 where one is, from whole bodies down to the anterior iliac spines and the legs, 0.75
# where knees and ankles have no marker; 0.85 where the labels of both legs are exchanged.
MIRRORED = 0.78
GAIN = 0.02  # of the distance between exchanged labels by which inverse kinematics comes nearer
LOOSE, MUCH = 0.5, 0.03  # a marker of the other leg: its spread there over that here, and here [m]
_YAWS = np.deg2rad(np.arange(0, 360, 5))


@dataclass(frozen=True)
class Landmarks:
    """Markers of known place on a standing person.

    Attributes:
        human: The person.
        names: Marker names.
        places: Where each sits.
    """

    human: Human
    names: tuple[str, ...]
    places: tuple[Attachment, ...]

    @property
    def standing(self) -> Float[Array, "n_markers 3"]:
        """Positions on the standing person, who faces x [m]."""
        return PointSet.of(self.human, list(self.places)).path(self.human.standing()[None])[0]


@dataclass(frozen=True)
class Exchange:
    """Labels that stand at each other's markers.

    Attributes:
        recorded_as: Label → the label under which its marker was recorded, where they differ.
    """

    recorded_as: dict[str, str]

    @classmethod
    def of(cls, names: Sequence[str], order: np.ndarray) -> "Exchange":
        """Return the exchange that takes the marker of each label from column ``order``."""
        taken = {name: str(names[k]) for name, k in zip(names, order, strict=True)}
        return cls({name: own for name, own in taken.items() if name != own})

    def __bool__(self) -> bool:
        """Return whether any label is exchanged."""
        return bool(self.recorded_as)

    @property
    def cycles(self) -> list[tuple[str, ...]]:
        """The labels that are exchanged with each other: mostly pairs."""
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
        """Return the markers under the labels they belong to."""
        columns = [markers.index(self.recorded_as.get(name, name)) for name in markers.names]
        return replace(markers, positions=markers.positions[:, columns])


def exchanged_by_anatomy(
    known: Landmarks, samples: Float[Array, "n_frames n_markers 3"], source: object
) -> Exchange:
    """Return the labels that must be exchanged for the markers to be those of a person.

    Args:
        known: The markers whose place is known.
        samples: Their positions [m]; NaN where not seen.
        source: The file, for the message.

    Raises:
        FitError: If the person is mirrored.
    """
    usual = _with_their_limb(known, distances(samples).spread)
    frames = samples[np.isfinite(samples[..., 0]).sum(axis=1) >= min(6, len(usual))]
    if len(frames):
        frames = frames[np.unique(np.linspace(0, len(frames) - 1, FRAMES).astype(int))]
        frames = _head_up(frames, known.standing)
        order, cost = _labelling(known, frames, usual)
        if _labelling(known, frames * MIRROR, usual)[1] < MIRRORED * cost:
            raise FitError(mirrored(source))
        usual = order
    return Exchange.of(known.names, usual)


def _head_up(
    frames: Float[Array, "n_frames n 3"], standing: Float[Array, "n 3"]
) -> Float[Array, "n_frames n 3"]:
    """Return the frames turned over where the person is upside down: a fit starts from standing."""
    up = frames[..., 2] - np.nanmean(frames[..., 2], axis=1, keepdims=True)
    upside_down = np.nansum(up * (standing[:, 2] - standing[:, 2].mean())) < 0
    return frames * [1.0, -1.0, -1.0] if upside_down else frames


def _labelling(
    known: Landmarks, frames: Float[Array, "n_frames n_markers 3"], usual: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return the column that each label's marker is taken from, and what that costs [m].

    The cost is the mean distance to the nearest pose of a person of usual proportions, times one
    plus the share of the labels that are exchanged.
    """
    some = frames[np.unique(np.linspace(0, len(frames) - 1, CONFIRMED_ON).astype(int))]
    height = known.human.height * _scale(known, frames)
    h = known.human
    human = Human.create(float(np.clip(height, 0.6, 2.4)), h.mass, h.sex, h.joints, h.feet)
    here, order = some[:, usual], _as_a_person_stands(known, frames, usual)
    errors = _errors(human, known.places, here)
    moved = order != usual
    if moved.any():
        there = some[:, order]
        gain = errors - (exchanged := _errors(human, known.places, there))
        if np.nansum(gain) > GAIN * np.nansum(np.linalg.norm(here - there, axis=-1)):
            return order, float(np.nanmean(exchanged)) * (1 + moved.mean())
    return usual, float(np.nanmean(errors))


def _as_a_person_stands(
    known: Landmarks, frames: Float[Array, "n_frames n_markers 3"], order: np.ndarray
) -> np.ndarray:
    """Return the column that each label's marker is taken from to stand as a person does."""
    standing = known.standing
    standing = standing * _scale(known, frames)
    trunk = np.array([p.body in TRUNK for p in known.places], dtype=bool)
    e = standing[:, None] - standing
    length2 = np.maximum((e**2).sum(axis=-1), 1e-12)
    twins = np.triu(_twins(known))
    told = np.triu(_comparable(known) & (length2 >= APART**2))
    moves = [np.array([pair]) for pair in np.argwhere(told)]
    limb = _limbs(known)
    moves += [pairs for b in sorted({*limb}) if len(pairs := _of_limb(twins, limb == b)) > 1]
    least = np.array([OPPOSITE if len(pairs) == 1 else LIMB_OPPOSITE for pairs in moves])
    groups = [np.flatnonzero(limb == b) for b in sorted({*limb}) if not b.startswith(FREE)]
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
    """Return the column of each label of a segment by the best assignment, and what it gains [m²].

    Parts of the assignment that exchange landmarks near to each other, or gain less than opposite
    labels do, are left out.
    """
    none = np.arange(len(standing))
    whole = x[np.isfinite(x[..., 0]).all(axis=1)]
    if len(none) < 2 or not len(whole):
        return none, 0.0
    p = standing - standing.mean(axis=0)
    alike = np.median((whole - whole.mean(axis=1, keepdims=True)) @ p.T, axis=0)  # column, label
    labels, columns = linear_sum_assignment(-alike.T)
    taken, total = none.copy(), 0.0
    left = {int(k) for k in labels[labels != columns]}
    while left:
        cycle = [left.pop()]
        while (after := int(columns[cycle[-1]])) != cycle[0]:
            cycle.append(after)
            left.discard(after)
        to = columns[cycle]
        gain = float((alike[to, cycle] - alike[cycle, cycle]).sum())
        apart2 = ((p[cycle] - p[to]) ** 2).sum(axis=1)
        if gain > -OPPOSITE * apart2.sum() / 2 and apart2.min() >= APART**2:
            taken[cycle], total = to, total + gain
    return taken, total


def _limbs(known: Landmarks) -> np.ndarray:
    """Return the part of a limb that each marker is on; foot and toes are one."""
    limbs = ("pelvis", "femur", "tibia", "humerus", "forearm", "hand")
    bodies = [p.body for p in known.places]
    foot = [b.endswith(("_r", "_l")) and not b.startswith((*limbs, *FREE, "clav")) for b in bodies]
    return np.array([f"foot{b[-2:]}" if f else b for b, f in zip(bodies, foot, strict=True)])


def _of_limb(twins: Bool[Array, "n n"], on_it: Bool[Array, " n"]) -> np.ndarray:
    """Return the twins of which one is on a part of a limb, (n_pairs, 2)."""
    return np.argwhere(twins & (on_it[:, None] | on_it))


def _with_their_limb(known: Landmarks, spread: Float[Array, "n n"]) -> np.ndarray:
    """Return the columns with every marker on the limb to which its distances are constant."""
    order = np.arange(len(known.names))
    for _ in known.names:
        pair = _on_the_other_limb(known, spread[np.ix_(order, order)])
        if pair is None:
            break
        order[[*pair]] = order[[*pair[::-1]]]
    return order


def _on_the_other_limb(known: Landmarks, spread: Float[Array, "n n"]) -> tuple[int, int] | None:
    """Return two twins whose distances to the other limb's markers are constant, not to their own.

    A walking person's medial knee markers pass so near to each other that only this tells them.
    """
    body = _limbs(known)
    best, worst = None, MUCH
    for i, j in np.argwhere(np.triu(_twins(known))):
        here, there = np.flatnonzero(body == body[i]), np.flatnonzero(body == body[j])
        here, there = here[here != i], there[there != j]
        if not len(here) or not len(there):
            continue
        own = _usual(spread[i, here]) + _usual(spread[j, there])
        other = _usual(spread[i, there]) + _usual(spread[j, here])
        if own > worst and other < LOOSE * own:
            best, worst = (int(i), int(j)), own
    return best


def _usual(spread: Float[Array, " n"]) -> float:
    """Return the median of the spreads that are known; nothing is known of none."""
    seen = spread[np.isfinite(spread)]
    return float(np.median(seen)) if len(seen) else float("nan")


def _twins(known: Landmarks) -> Bool[Array, "n n"]:
    """Return the pairs that are the same point of the left and the right limb."""
    body = np.array([p.body for p in known.places])
    segment = np.array([name[:-2] if name.endswith(("_r", "_l")) else name for name in body])
    position = np.array([p.position for p in known.places])
    twin = np.abs(position[:, None] * MIRROR - position).max(axis=-1) < 1e-6
    return twin & (segment[:, None] == segment) & (body[:, None] != body)


def _comparable(known: Landmarks) -> Bool[Array, "n_markers n_markers"]:
    """Return the pairs whose vector is known: of one segment, or of left and right."""
    limb = _limbs(known)
    free = np.array([name.startswith(FREE) for name in limb], dtype=bool)
    # On pelvis, trunk and head the point of the other side is on the same segment.
    return _twins(known) | ((limb[:, None] == limb) & ~free)


def _scale(known: Landmarks, frames: Float[Array, "n_frames n 3"]) -> float:
    """Return the size of the recorded person over that of the standing one.

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
    turned = np.full_like(frames, np.nan)
    c, s = np.cos(_YAWS), np.sin(_YAWS)
    for f, frame in enumerate(frames):
        seen = np.isfinite(frame[:, 0])
        use = seen & trunk if (seen & trunk).sum() >= ENOUGH else seen
        a, b = standing[use], frame[use]
        ahead = c[:, None] * b[:, 0] + s[:, None] * b[:, 1]
        aside = -s[:, None] * b[:, 0] + c[:, None] * b[:, 1]
        away = np.stack([ahead, aside, np.broadcast_to(b[:, 2], ahead.shape)], axis=-1) - a
        away -= np.median(away, axis=1, keepdims=True)
        k = np.linalg.norm(away, axis=-1).mean(axis=1).argmin()
        turned[f] = frame @ np.array([[c[k], -s[k], 0], [s[k], c[k], 0], [0, 0, 1.0]])
    return turned


def _median(values: np.ndarray) -> np.ndarray:
    """Return the median over frames; infinite where a pair is never seen."""
    ordered = np.sort(values, axis=0)  # NaN come last
    count = np.isfinite(values).sum(axis=0)
    middle = np.take_along_axis(ordered, np.maximum(count - 1, 0)[None] // 2, axis=0)[0]
    return np.where(count > 0, middle, np.inf)


def _errors(human: Human, places: Sequence[Attachment], frames: np.ndarray) -> np.ndarray:
    """Return how far the markers are from the nearest pose of a person of usual proportions [m]."""
    solver = InverseKinematics(PointSet.of(human, list(places)), tolerance=1e-3, max_iterations=25)
    starts = standing_poses(human, list(places), frames)
    return np.array([solver.solve(f, q).residual for f, q in zip(frames, starts, strict=True)])
