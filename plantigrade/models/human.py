"""A person as one compiled MuJoCo model with named coordinates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.errors import CoordinateNotFound, ParameterError, known_names
from plantigrade.models.anthropometry import Dimensions, check_range, dimensions
from plantigrade.models.joint_sets import NATIVE_FEET, moving_parts
from plantigrade.models.loads import check_loads, loaded
from plantigrade.models.mjcf import to_mjcf, with_contact_heights, with_gravity, with_inertia
from plantigrade.models.parts import Inertia
from plantigrade.models.skeleton import Skeleton, build
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    PELVIS,
    pelvis_angles_to_quaternion,
    quaternion_to_pelvis_angles,
)

if TYPE_CHECKING:
    import mujoco

MAX_SOLE_OFFSET = 0.1
"""Largest displacement of a contact sphere from its default position [m]."""
MAX_TRUNK_SHIFT = 0.15
"""Largest displacement of the trunk's centre of mass from its default position [m]."""
MIN_GRAVITY, MAX_GRAVITY = 0.1, 2.0
"""Range of gravity, relative to the earth's [1]: the moon has 0.165, Jupiter 2.5."""
_STANDING_ARMS = {"pro_sup": 1.4, "arm_add": -0.14}
"""Angles of hanging arms [rad]: palms towards the thighs, clear of the hips."""


@dataclass(frozen=True)
class Human:
    """A person: lengths, masses, joints, feet, and the MuJoCo model built from them.

    Build one with :meth:`create`.

    Attributes:
        height: Stature [m].
        mass: Body mass [kg].
        sex: ``"female"`` or ``"male"``.
        joints: Joint set (:data:`plantigrade.models.joint_sets.JOINT_SETS`).
        feet: Kind of foot (:data:`plantigrade.models.feet.FEET`).
        dimensions: All lengths.
        skeleton: Bodies and where every anatomical part is.
        xml: The model as MJCF text, which loads in plain MuJoCo.
        soles: Upward displacement of contact spheres (:meth:`with_soles`), by name [m].
        trunk_mass: Displacement of the trunk's centre of mass (:meth:`with_trunk_mass`) [m].
        full_sole: Whether the feet contact the ground at all sixteen points of the multi-segment
            foot (:func:`plantigrade.models.feet.foot_parts`).
        loads: Masses carried (:meth:`with_loads`), by place [kg]; they do not belong to ``mass``.
    """

    height: float
    mass: float
    sex: str
    joints: str
    feet: str
    dimensions: Dimensions
    skeleton: Skeleton = field(repr=False)
    xml: str = field(repr=False)
    soles: Mapping[str, float] = field(default_factory=dict, repr=False)
    trunk_mass: tuple[float, float, float] = (0.0, 0.0, 0.0)
    full_sole: bool = False
    loads: Mapping[str, float] = field(default_factory=dict, repr=False)

    @classmethod
    def create(
        cls,
        height: float = 1.74,
        mass: float = 71.0,
        sex: str = "male",
        joints: str = "42",
        feet: str | None = None,
        lengths: Mapping[str, float] | None = None,
        full_sole: bool = False,
    ) -> "Human":
        """Return a person.

        Args:
            height: Stature [m], 0.5 to 2.5; exact in the model.
            mass: Body mass [kg], 5 to 300; exact in the model.
            sex: ``"female"`` or ``"male"``.
            joints: ``"42"``, ``"43"``, ``"58"`` or ``"66"``.
            feet: ``"rigid"``, ``"two-segment"`` or ``"multi-segment"``; by default that of the
                joint set.
            lengths: Individual segment lengths [m], named as in :class:`Dimensions`.
            full_sole: Whether every foot has the same sixteen ground contacts, for comparisons of
                feet; the multi-segment foot always has them.

        Raises:
            ParameterError: If a value is not allowed.

        Example:
            >>> human = Human.create(height=1.50, mass=48.5, joints="66")
            >>> human.model.nv
            66
        """
        check_range("mass", mass, 5.0, 300.0, "kg")
        d = dimensions(height, sex, lengths)
        moving_parts(joints, "rigid")  # refuses an unknown joint set before its foot is looked up
        feet = feet or NATIVE_FEET[joints]
        skeleton = build(d, sex, float(mass), joints, feet, full_sole)
        moving = moving_parts(joints, feet)
        names = {c for m in moving.values() for c in m.coordinates}
        standing = {f"{c}_{s}": v for c, v in _STANDING_ARMS.items() if c in names for s in SIDES}
        ankle = skeleton.origins["foot_r"][2]
        xml = to_mjcf(
            f"human-{joints}-{feet}",
            skeleton,
            pelvis_height=d.ankle_height - ankle,
            standing=standing,
        )
        person = (float(height), float(mass), sex, joints, feet, d)
        return cls(*person, skeleton, xml, full_sole=full_sole)

    @cached_property
    def model(self) -> "mujoco.MjModel":
        """The compiled MuJoCo model."""
        import mujoco

        return mujoco.MjModel.from_xml_string(self.xml)

    @cached_property
    def gravity(self) -> float:
        """Acceleration of gravity where the person is, as the model has it [m/s²]."""
        return float(np.linalg.norm(self.model.opt.gravity))

    @property
    def on_earth(self) -> bool:
        """Whether gravity is that of the earth, for which controllers are made."""
        return abs(self.gravity / GRAVITY - 1.0) < 0.01

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the hinges, in the order of ``qpos[7:]`` and ``qvel[6:]``."""
        return tuple(h.name for b in self.skeleton.bodies for h in b.hinges)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the MuJoCo joints: ``root``, then the hinges."""
        return ("root", *self.coordinates)

    @cached_property
    def body_names(self) -> tuple[str, ...]:
        """Names of the moving segments; body ``i`` of the model is ``body_names[i - 1]``."""
        return tuple(b.name for b in self.skeleton.bodies)

    @property
    def trunk(self) -> str:
        """Name of the body that represents the trunk or its largest part."""
        return "torso" if "torso" in self.body_names else "thorax"

    def body(self, name: str) -> int:
        """Return the index of a body in the model.

        Raises:
            CoordinateNotFound: If there is no such body.
        """
        if name not in self.body_names:
            raise CoordinateNotFound(f"no body {name!r}; {known_names(name, self.body_names)}")
        return self.body_names.index(name) + 1

    def both(self, name: str) -> list[int]:
        """Return the indices of the right and the left body of a name, such as ``"foot"``."""
        return [self.body(f"{name}_{side}") for side in SIDES]

    def hinge(self, coordinate: str) -> int:
        """Return the index of a hinge within :attr:`coordinates`.

        Raises:
            CoordinateNotFound: If this person has no such coordinate.
        """
        if coordinate not in self.coordinates:
            raise CoordinateNotFound(
                f"no coordinate {coordinate!r} in joint set {self.joints} with {self.feet} feet; "
                f"{known_names(coordinate, self.coordinates)}"
            )
        return self.coordinates.index(coordinate)

    @cached_property
    def limits(self) -> Float[Array, "2 n_hinges"]:
        """Lower and upper limits of the hinges [rad]."""
        hinges = [h for b in self.skeleton.bodies for h in b.hinges]
        return np.array([[h.low for h in hinges], [h.high for h in hinges]])

    @cached_property
    def contact_points(self) -> tuple[tuple[str, str, str], ...]:
        """(geom name, side, foot segment) of every contact sphere."""
        return tuple(
            (name, b.name[-1], c.segment)
            for b in self.skeleton.bodies
            for name, c in zip(b.contact_names, b.contacts, strict=True)
        )

    def standing(self) -> Float[Array, " nq"]:
        """Return the configuration of quiet standing at the origin, feet on the ground."""
        return np.array(self.model.key_qpos[0])

    def to_coordinates(
        self, qpos: Float[Array, "n_frames nq"]
    ) -> tuple[tuple[str, ...], Float[Array, "n_frames n_coordinates"]]:
        """Return OpenSim's coordinates of configurations: names and values [rad, m].

        Pelvis translations are in OpenSim's axes (x forward, y up, z right).
        """
        translation = qpos[:, :3] @ OPENSIM_TO_WORLD
        angles = quaternion_to_pelvis_angles(qpos[:, 3:7])
        return PELVIS + self.coordinates, np.hstack([angles, translation, qpos[:, 7:]])

    def file_coordinates(
        self, qpos: Float[Array, "n_frames nq"]
    ) -> tuple[tuple[str, ...], Float[Array, "n_frames n_coordinates"]]:
        """Return the coordinates that move this person in OpenSim, as its files have them."""
        return self.to_coordinates(qpos)

    def from_coordinates(
        self, names: Sequence[str], values: Float[Array, "n_frames n_columns"]
    ) -> Float[Array, "n_frames nq"]:
        """Return configurations from OpenSim's coordinates, the inverse of :meth:`to_coordinates`.

        Coordinates that this person lacks are ignored; those not given keep their standing value.

        Args:
            names: Coordinate names.
            values: Their values [rad, m], one column each.

        Raises:
            ParameterError: If none of the names is a coordinate of this person.
        """
        if not set(names) & set(PELVIS + self.coordinates):
            raise ParameterError(
                f"none of the columns {', '.join(names[:8])} … is a coordinate of this person; "
                f"those are {', '.join(PELVIS + self.coordinates)}"
            )
        column = {name: values[:, i] for i, name in enumerate(names)}
        qpos = np.tile(self.standing(), (len(values), 1))
        angles = np.stack([column.get(n, np.zeros(len(values))) for n in PELVIS[:3]], axis=1)
        qpos[:, 3:7] = pelvis_angles_to_quaternion(angles)
        translation = qpos[:, :3] @ OPENSIM_TO_WORLD
        for places, names in ((translation, PELVIS[3:]), (qpos[:, 7:], self.coordinates)):
            for i, name in enumerate(names):
                places[:, i] = column.get(name, places[:, i])
        qpos[:, :3] = translation @ OPENSIM_TO_WORLD.T
        return qpos

    def with_soles(self, offsets: Mapping[str, float]) -> "Human":
        """Return the person with different soles, such as shoes or flatter feet.

        Only the contact spheres move; joints, masses and the drawn foot are unchanged.

        Args:
            offsets: Name of a contact sphere (as in :attr:`contact_points`) → upward displacement
                of its centre in the frame of its segment [m]; negative for a thicker sole.

        Raises:
            ParameterError: If there is no such sphere, or the total displacement of one exceeds
                :data:`MAX_SOLE_OFFSET`.
        """
        names = [name for name, _, _ in self.contact_points]
        for name, offset in offsets.items():
            if name not in names:
                raise ParameterError(f"no contact sphere {name!r}; there are {', '.join(names)}")
            total = self.soles.get(name, 0.0) + offset
            if not abs(total) <= MAX_SOLE_OFFSET:
                raise ParameterError(
                    f"the sole at {name} would be moved by {total:.3g} m; "
                    f"allowed are ±{MAX_SOLE_OFFSET} m"
                )
        skeleton = self.skeleton.with_contact_heights(offsets)
        total = {n: self.soles.get(n, 0.0) + offsets.get(n, 0.0) for n in {*self.soles, *offsets}}
        xml = with_contact_heights(self.xml, offsets)
        return replace(self, skeleton=skeleton, xml=xml, soles=total)

    def with_trunk_mass(self, offset: Sequence[float] | Float[Array, " 3"]) -> "Human":
        """Return the person with a displaced centre of mass of the trunk.

        Masses, inertia about the centre of mass, joints and lengths are unchanged.

        Args:
            offset: Displacement in the frame of the trunk, x forward, y left, z up [m].

        Raises:
            ParameterError: If the offset is not three numbers, or the total displacement exceeds
                :data:`MAX_TRUNK_SHIFT`.
        """
        offset = np.asarray(offset, dtype=float)
        if offset.shape != (3,):
            raise ParameterError(f"a displacement is three numbers, not {offset.tolist()}")
        total = np.array(self.trunk_mass) + offset
        if not np.linalg.norm(total) <= MAX_TRUNK_SHIFT:
            raise ParameterError(
                f"the trunk's centre of mass would be moved by {np.linalg.norm(total):.3g} m; "
                f"allowed are {MAX_TRUNK_SHIFT} m"
            )
        own = next(b.inertia for b in self.skeleton.bodies if b.name == self.trunk)
        moved = self._with_inertia({self.trunk: own.shifted(offset)})
        forward, left, up = total.tolist()
        return replace(moved, trunk_mass=(forward, left, up))

    def _with_inertia(self, changed: Mapping[str, Inertia]) -> "Human":
        """Return the person with other inertia of some bodies, by name."""
        xml = self.xml
        for name, inertia in changed.items():
            xml = with_inertia(xml, name, inertia)
        return replace(self, skeleton=self.skeleton.with_inertia(changed), xml=xml)

    def with_loads(self, loads: Mapping[str, float]) -> "Human":
        """Return the person with loads in addition to those carried already.

        Args:
            loads: Place → mass [kg]; places are those of :data:`plantigrade.models.loads.PLACES`,
                such as ``"back"``, ``"hand_r"`` and ``"foot_l"``.

        Raises:
            ParameterError: If there is no such place, or a mass is out of range.
        """
        total = {**self.loads, **{n: self.loads.get(n, 0.0) + m for n, m in loads.items()}}
        check_loads(total)
        heavier = self._with_inertia(loaded(self.skeleton, loads, self.height))
        return replace(heavier, loads=total)

    def with_gravity(self, gravity: float) -> "Human":
        """Return the person where gravity is another one, as on the moon; weight changes with it.

        Args:
            gravity: Acceleration of gravity [m/s²].

        Raises:
            ParameterError: If it is out of range.
        """
        check_range("gravity", gravity / GRAVITY, MIN_GRAVITY, MAX_GRAVITY, "of the earth's")
        return replace(self, xml=with_gravity(self.xml, float(gravity)))

    def with_mass(self, mass: float) -> "Human":
        """Return the person with another body mass [kg] and the same lengths.

        Raises:
            ParameterError: If the mass is not allowed.
        """
        return Human.from_dict({**self.to_dict(), "mass": mass})

    def to_dict(self) -> dict:
        """Return a JSON-serialisable description of the person; see :meth:`from_dict`."""
        d = self.dimensions
        unusual = {
            "trunk_mass": list(self.trunk_mass) if any(self.trunk_mass) else None,
            "full_sole": self.full_sole,
            "loads": dict(self.loads),
            "gravity": None if self.gravity == GRAVITY else self.gravity,
        }
        return {
            **{k: getattr(self, k) for k in ("height", "mass", "sex", "joints", "feet")},
            "lengths": {name: getattr(d, name) for name in d.names()},
            "soles": dict(self.soles),
            **{k: v for k, v in unusual.items() if v},
        }

    @classmethod
    def from_dict(cls, description: Mapping) -> "Human":
        """Return the person described by :meth:`to_dict`.

        Raises:
            ParameterError: If an entry is missing, of the wrong type or not allowed.
        """
        try:
            d = dict(description)
            soles = {str(k): float(v) for k, v in d.pop("soles", {}).items()}
            trunk = [float(v) for v in d.pop("trunk_mass", (0.0, 0.0, 0.0))]
            loads = {str(k): float(v) for k, v in d.pop("loads", {}).items()}
            gravity = float(d.pop("gravity", GRAVITY))
            human = cls.create(**d)
            human = human.with_gravity(gravity) if gravity != GRAVITY else human
            human = human.with_trunk_mass(trunk) if any(trunk) else human
            human = human.with_loads(loads) if loads else human
        except (TypeError, ValueError, AttributeError, OverflowError) as error:
            if isinstance(error, ParameterError):
                raise
            raise ParameterError(f"not a description of a person: {error}") from error
        return human.with_soles(soles) if soles else human

    def body_positions(self, d: Dimensions) -> Float[Array, "n_bodies 3"]:
        """Return the origin of every body in its parent for other lengths, in model order [m].

        The first row (the pelvis, moved by the free joint) is zero.
        """
        other = build(d, self.sex, self.mass, self.joints, self.feet)
        return np.array([b.position if b.parent else np.zeros(3) for b in other.bodies])


def require_scaled(human: Human, what: str) -> None:
    """Refuse a user's own model, which has no anatomy of this package."""
    if type(human) is not Human:
        raise ParameterError(
            f"{what} needs a scaled human, and this run is on a model of your own: fit the "
            "recording without --model"
        )
