"""A person with the sites that can carry force, ready for trajectory optimisation."""

from collections.abc import Callable, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import ContactSite, foot_sites
from plantigrade.dynamics.passive import passive_moments, scale
from plantigrade.dynamics.symbolic import SymbolicHuman
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.spatial.conventions import surface_axes
from plantigrade.trajopt.problem.constraint_family import node_symbols
from plantigrade.trajopt.problem.external import Acting, External, Worn

if TYPE_CHECKING:
    import casadi

TORQUE_SCALE = 100.0
"""Torque and work rate of one unit in rows, for the reference mass and height [N m, W]; others
scale with mass times height, like strengths."""
PASSIVE_JOINTS = ("hip", "knee", "ankle", "subtalar", "mtp", "lumbar", "lower_thorax", "thorax")
"""Prefixes of joints whose passive tissue carries a part of the limited torque."""
Made = TypeVar("Made")


@runtime_checkable
class Spring(Protocol):
    """A spring across a joint: coordinate, stiffness [N m/rad] and neutral angle [rad]."""

    @property
    def coordinate(self) -> str:
        """Name of the coordinate."""
        ...

    @property
    def stiffness(self) -> float:
        """Stiffness [N m/rad]."""
        ...

    @property
    def neutral(self) -> float:
        """Angle without moment [rad]."""
        ...


class Cache:
    """Cache of expensive objects."""

    def __init__(self):
        self._made: dict[Any, Any] = {}

    def get(self, key: Any, make: Callable[[], Made]) -> Made:
        """Return what is kept under a key, made where it is not there yet."""
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]


class ContactBody:
    """A person with the sites that can carry force.

    Args:
        plan: Says how the ground slopes; level if absent. Motions are in the axes of the ground,
            in which gravity leans.

    Attributes:
        human: The person.
        sites: Places that can carry force.
        passive: Whether passive tissue provides part of the torques, and muscles the rest.
        braces: Springs across joints that the person wears.
        external: Wrenches on the body, and devices that add torque at joints.
        symbolic: Equations of motion.
        cache: Functions and matrices made for this body.
    """

    def __init__(
        self,
        human: Human,
        sites: Sequence[ContactSite],
        *,
        passive: bool = True,
        plan: ContactPlan | None = None,
        braces: Sequence[Spring] = (),
        wrenches: Sequence[Acting] = (),
        devices: Sequence[Worn] = (),
    ):
        self.human, self.sites, self.passive = human, tuple(sites), passive
        self.braces = tuple(braces)
        self.external = External(wrenches, devices, plan)
        gravity = np.array(human.model.opt.gravity)
        self.symbolic = SymbolicHuman(human, gravity if plan is None else plan.to_world.T @ gravity)
        self.cache = Cache()
        held = {} if plan is None else {s.site.name: s for s in plan.supports}
        #: Axes of the surface under each site, the normal last (n_sites, 3, 3)
        self.surfaces = np.stack([
            surface_axes(np.array(held[s.name].normal)) if s.name in held else np.eye(3)
            for s in self.sites
        ]) if self.sites else np.zeros((0, 3, 3))  # fmt: skip
        #: Coefficient of friction of each site's own support; NaN where it is the ground's
        self.own_friction = np.array(
            [getattr(held.get(s.name), "friction", None) for s in self.sites], dtype=float
        )
        #: Pitch of each site's body from which its sphere rolls [rad]
        self.pitch = np.array([getattr(held.get(s.name), "pitch", 0.0) for s in self.sites])

    def friction(self, of_ground: float) -> Float[Array, " n_sites"]:
        """Return the coefficient of friction at each site, by that of the ground."""
        return np.where(np.isnan(self.own_friction), of_ground, self.own_friction)

    @classmethod
    def for_plan(
        cls,
        human: Human,
        plan: ContactPlan,
        braces: Sequence[Spring] = (),
        wrenches: Sequence[Acting] = (),
        devices: Sequence[Worn] = (),
    ) -> "ContactBody":
        """Return a person with every site a plan may load: both feet, and its supports."""
        places = {s.site.name: s.site for s in plan.supports}
        worn = {"braces": braces, "wrenches": wrenches, "devices": devices}
        return cls(human, (*foot_sites(human), *places.values()), plan=plan, **worn)

    def wearing(
        self,
        devices: Sequence[Worn],
        wrenches: Sequence[Acting] | None = None,
        plan: ContactPlan | None = None,
    ) -> "ContactBody":
        """Return the same body with other devices at the same joints; functions are shared.

        Args:
            wrenches: Other wrenches at the same points; its own if absent.
            plan: The same contacts at other times; its own if absent.

        Raises:
            ParameterError: If they are at other joints or points.
        """
        own = self.external
        mine, theirs = ([d.coordinate for d in x] for x in (own.devices, devices))
        if mine != theirs:
            raise ParameterError(f"devices at {theirs}, and the body was made for {mine}")
        wrenches = own.wrenches if wrenches is None else wrenches
        if [w.point for w in wrenches] != [w.point for w in own.wrenches]:
            raise ParameterError("wrenches at other points than those the body was made for")
        other = copy(self)
        other.external = External(wrenches, devices, own.plan if plan is None else plan)
        return other

    def tissue(self, q: Any, v: Any) -> list[Any]:
        """Return the moments of passive tissue and of braces, at angles and rates of the hinges.

        Args:
            q: Angles, a list of arrays or a CasADi vector [rad].
            v: Their rates [rad/s].

        Returns:
            One moment per hinge [N m].
        """
        names = self.symbolic.names[6:]
        moments: list[Any] = [0.0 * v[i] for i in range(len(names))]
        if self.passive:
            moments = passive_moments(names, q, v, scale(self.human.mass, self.human.height))
        for brace in self.braces:
            i = names.index(brace.coordinate)
            moments[i] = moments[i] - brace.stiffness * (q[i] - brace.neutral)
        return moments

    def check_worn(self, brace: Spring) -> None:
        """Check that the person wears a brace.

        Raises:
            ParameterError: If not.
        """
        if brace not in self.braces:
            raise ParameterError(
                f"the task braces {brace.coordinate}, and the body wears no such brace: make it "
                "with task.body_of(human)"
            )

    def function(
        self, key: Any, expression: Callable[..., Any], n_parameters: int = 0
    ) -> "casadi.Function":
        """Return a function of a node, made at the first call.

        Args:
            key: Its name; with numbers if it depends on them.
            expression: (ca, q, qd, qdd, u, p) ↦ column of rows.
        """

        def make() -> "casadi.Function":
            import casadi as ca

            given = node_symbols(self.symbolic.nv, 3 * len(self.sites), n_parameters)
            return ca.Function("rows", list(given), [expression(ca, *given)])

        return self.cache.get(("function", key), make)

    @property
    def weight(self) -> float:
        """Body weight [N]."""
        return self.symbolic.mass * float(np.linalg.norm(self.symbolic.gravity))

    @property
    def torque(self) -> float:
        """A torque of 1 in rows [N m], and a work rate of 1 [W]."""
        return TORQUE_SCALE * scale(self.human.mass, self.human.height)

    @property
    def stiff(self) -> tuple[str, ...]:
        """Hinges whose passive tissue carries a part of the limited torque."""
        return tuple(
            n for n in self.symbolic.names[6:] if self.passive and n.startswith(PASSIVE_JOINTS)
        )

    @property
    def force_names(self) -> tuple[str, ...]:
        """Names of node unknowns, three forces a site."""
        return tuple(f"force {axis} of {s.name}" for s in self.sites for axis in "xyz")
