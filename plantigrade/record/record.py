"""A record: a Human's motion with its forces, and all that should be known about it.

Every engine returns a Record, and everything above the engines (the checker, the report, the
viewer, export, comparison) reads nothing else.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.charts import Figure
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import ContactSite
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion.motion import Motion
from plantigrade.motion.recording import Markers
from plantigrade.motion.views import table_html
from plantigrade.record import views
from plantigrade.record.conditions import Condition
from plantigrade.record.signals import check_signals


@dataclass(frozen=True, eq=False)
class Limits:
    """Limits of a motion; None for those of the Human, or for no limit."""

    #: Lower and upper limits of the hinges [rad]; None: the Human's own
    coordinate: Float[Array, "2 n_hinges"] | None = None
    #: Largest speed of the hinges, one number or one each [rad/s]; None: no limit
    velocity: float | Float[Array, " n_hinges"] | None = None
    #: Lower and upper limits of the hinges' torques [N m]; None: the Human's own
    torque: Float[Array, "2 n_hinges"] | None = None
    force: float | None = None  #: Largest normal force at one site [N]; None: no limit
    #: Largest penetration between parts of the body [m]; None: not checked, as in fitted motions,
    #: whose solids are not the person's
    overlap: float | None = None


@dataclass(frozen=True, eq=False)
class FootForce:
    """Ground reaction on one foot."""

    force: Float[Array, "n_frames 3"]  #: Sum of the forces, world [N]
    centre_of_pressure: Float[Array, "n_frames 3"]  #: Where it acts, world [m]; NaN without load
    torque: Float[Array, "n_frames 3"]  #: Free moment about that point, world [N m]
    known: Bool[Array, " n_frames"]  #: Where the force is known at all, measured or estimated
    #: Where the force was measured, not estimated (``forces.measured``)
    measured: Bool[Array, " n_frames"]


@dataclass(frozen=True, eq=False)
class Record:
    """A motion and its forces.

    Attributes:
        human: The person.
        motion: The motion.
        qfrc_actuator: Generalised force of the joints [N m]; its first six entries hold what the
            dynamics leave unexplained at the root (residual), world force [N], body moment [N m].
        sites: Contact sites of the body.
        contact_force: Ground reaction on the body at each site, world [N].
        contact_point: Where it acts, world [m]; NaN where the force is zero.
        contact_torque: Free moment at that point, world [N m], where known.
        contact_known: Where the force at a site is known at all; None: everywhere. A foot
            off its force plate carries a force that was not measured.
        contact_planned: When each site was planned to be in contact; None without a plan.
        ground: The ground.
        limits: Limits of the motion.
        conditions: Conditions of the task, on the clock of ``motion``.
        signals: Further results by name, as arrays of numbers or words: residuals of tasks, the
            history of a solver, the state of a controller. Their names, units and shapes are those
            of :data:`~plantigrade.record.signals.SIGNALS`; your own begin with ``user.``.
        references: Other motions of the same Human by name, on clocks of their own: the recorded
            motion of a reproduced one.
        recorded_markers: The recorded markers, on the frames of ``motion``.
        fitted_markers: The same markers on the body, world [m].
        clock: Time zero of ``motion`` on the clock of the recording [s].
        notes: Warnings to the user, one sentence each; those of type
            :class:`~plantigrade.notes.Info` only inform.
    """

    human: Human
    motion: Motion
    qfrc_actuator: Float[Array, "n_frames nv"] | None = None
    sites: tuple[ContactSite, ...] = ()
    contact_force: Float[Array, "n_frames n_sites 3"] | None = None
    contact_point: Float[Array, "n_frames n_sites 3"] | None = None
    contact_torque: Float[Array, "n_frames n_sites 3"] | None = None
    contact_known: Bool[Array, "n_frames n_sites"] | None = None
    contact_planned: Bool[Array, "n_frames n_sites"] | None = None
    ground: Ground = field(default_factory=Ground)
    limits: Limits = field(default_factory=Limits)
    conditions: tuple[Condition, ...] = ()
    signals: Mapping[str, Array] = field(default_factory=dict)
    references: Mapping[str, Motion] = field(default_factory=dict)
    recorded_markers: Markers | None = None
    fitted_markers: Float[Array, "n_frames n_markers 3"] | None = None
    clock: float = 0.0
    notes: tuple[str, ...] = ()

    def __post_init__(self):
        """Refuse what does not fit the motion, the sites or the Human: readers trust a Record."""
        n, k, nv = self.motion.n_frames, len(self.sites), self.human.model.nv
        if self.motion.joint_names != self.human.joint_names:
            raise ParameterError(
                f"the motion has {len(self.motion.joint_names) - 1} hinges, this person has "
                f"{len(self.human.coordinates)}"
            )
        shapes = {
            "qfrc_actuator": (n, nv),
            **dict.fromkeys(("contact_force", "contact_point", "contact_torque"), (n, k, 3)),
            **dict.fromkeys(("contact_known", "contact_planned"), (n, k)),
        }
        markers, fitted = self.recorded_markers, self.fitted_markers
        if fitted is not None and markers is None:
            raise ParameterError("fitted_markers need recorded_markers, which name them")
        arrays = {name: getattr(self, name) for name in shapes}
        if markers is not None:
            arrays |= {"recorded_markers": markers.positions, "fitted_markers": fitted}
            size = (n, len(markers.names), 3)
            shapes |= {"recorded_markers": size, "fitted_markers": size}
        for name, shape in shapes.items():
            value = arrays[name]
            if value is not None and value.shape != shape:
                raise ParameterError(f"{name} has shape {value.shape}; here it must be {shape}")
        for site in self.sites:
            if site.body not in self.human.body_names:
                bodies = ", ".join(self.human.body_names)
                what = f"contact site {site.name!r}: no body {site.body!r}; there are {bodies}"
                raise ParameterError(what)
        for name, other in self.references.items():
            if other.joint_names != self.motion.joint_names or not other.n_frames:
                raise ParameterError(f"reference {name!r} is not a motion of this person")
        check_signals(self.signals, n, nv, None if markers is None else len(markers.names))

    @property
    def weight(self) -> float:
        """Body weight [N]."""
        return self.human.mass * self.human.gravity

    @property
    def has_forces(self) -> bool:
        """Whether it holds ground reactions."""
        return self.contact_force is not None and len(self.sites) > 0

    @property
    def device_torque(self) -> Float[Array, "n_frames nv"]:
        """Part of the joint torques that devices add [N m]; zero without one."""
        added = self.signals.get("device.torque")
        return np.zeros(self.motion.qvel.shape) if added is None else np.asarray(added, float)

    def torque(self, hinge: str) -> Float[Array, " n_frames"]:
        """Return the torque of a hinge by name [N m].

        Raises:
            ParameterError: If the record has no torques.
            CoordinateNotFound: If there is no such hinge.
        """
        if self.qfrc_actuator is None:
            raise ParameterError("this record has no joint torques: no forces were known")
        return self.qfrc_actuator[:, 6 + self.motion.hinge(hinge)]

    def foot(self, side: str) -> FootForce:
        """Return the ground reaction on a foot, ``"r"`` or ``"l"``; zero where nothing touches it.

        The centre of pressure is the mean of the points, weighted by the force along the normal.
        """
        n = self.motion.n_frames
        mine = [k for k, site in enumerate(self.sites) if site.side == side]
        if self.contact_force is None or not mine:
            zero, known = np.zeros((n, 3)), np.ones(n, dtype=bool)
            return FootForce(zero, np.full((n, 3), np.nan), zero.copy(), known, known.copy())
        force = np.nan_to_num(self.contact_force[:, mine])
        point = np.zeros_like(force)
        if self.contact_point is not None:
            point = np.nan_to_num(self.contact_point[:, mine])
        load = force @ self.ground.normal
        total, whole = force.sum(axis=1), load.sum(axis=1)[:, None]
        moved = (load[..., None] * point).sum(axis=1)
        centre = np.divide(moved, whole, out=np.full_like(moved, np.nan), where=whole > 1e-6)
        torque = np.cross(point - np.nan_to_num(centre)[:, None], force).sum(axis=1)
        if self.contact_torque is not None:
            torque += np.nan_to_num(self.contact_torque[:, mine]).sum(axis=1)
        torque[np.isnan(centre[:, 0])] = 0.0
        known = np.ones(n, dtype=bool)
        if self.contact_known is not None:
            known = np.all(self.contact_known[:, mine], axis=1)
        plates = self.signals.get("forces.measured")
        measured = known if plates is None else known & plates[:, SIDES.index(side)].astype(bool)
        return FootForce(total, centre, torque, np.asarray(known), np.asarray(measured))

    def group(self, prefix: str) -> dict[str, Any]:
        """Return the signals whose names start with ``prefix`` and a dot, by what follows it."""
        start = prefix + "."
        return {k.removeprefix(start): v for k, v in self.signals.items() if k.startswith(start)}

    def plot(self, *names: str) -> Figure:
        """Return a figure over time; a notebook shows it.

        Args:
            names: Coordinates (``"knee_angle"``: both sides), joint moments
                (``"knee_angle_moment"``), ground forces (``"ground_force_up"``), or signals of one
                number a frame; the coordinates that change if none is given.

        Raises:
            CoordinateNotFound: If there is no such coordinate, moment or signal.
            ParameterError: If forces are asked for that the record does not have.
        """
        return views.plot(self, names)

    def to_dataframe(self) -> Any:
        """Return coordinates, torques, ground forces and signals, one row a frame (pandas).

        Raises:
            MissingExtra: If pandas is not installed.
        """
        return views.to_dataframe(self)

    def to_xarray(self) -> Any:
        """Return the record as an xarray Dataset with named dimensions.

        Raises:
            MissingExtra: If xarray is not installed.
        """
        return views.to_xarray(self)

    def _repr_html_(self) -> str:
        return table_html("Record", views.record_summary(self))

    def __repr__(self) -> str:
        known = [f"{len(self.sites)} contact sites"] if self.sites else []
        known += ["torques"] if self.qfrc_actuator is not None else []
        known += [f"references {', '.join(self.references)}"] if self.references else []
        known += [f"{len(self.signals)} signals"] if self.signals else []
        human = f"{self.human.height:.2f} m, {self.human.mass:.1f} kg"
        return f"Record({human}, {self.motion!r}{''.join(', ' + word for word in known)})"
