r"""Equations of motion as families of rows: root, muscle torques, work rates, joint torques.

At every node the six equations of the root hold exactly with the forces of the ground, so every
joint torque is the one the joint really does. All families come from one inverse dynamics and are
evaluated together; each is limited and weighed on its own.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily, node_symbols
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.transcription.derivatives import derivatives_of

if TYPE_CHECKING:
    import casadi

WORK_RATE_ROUNDING = 0.5  #: Rounding of work rates, in units of rows [1]
ENDURANCE_ROUNDING = 0.05
"""Rounding of endurance, in units of rows [1]."""
ANKLE_ROUNDING = 0.02
"""Rounding of the transition from plantarflexors to dorsiflexors, in units of rows [1]."""


def dynamics(
    body: ContactBody, n_nodes: int, parameters: Float[Array, "n_nodes n_parameters"] | None = None
) -> ConstraintFamily:
    r"""Return the equations of motion, with what acts from outside at nodes as parameters.

    Its parts are

    - ``"root force"`` [body weights] and ``"root moment"`` [body weight · m], what nothing explains
      at the pelvis: zero;
    - ``"muscle torque"``, :math:`\tau` less what passive tissue, braces and devices bear
      [:attr:`ContactBody.torque`];
    - ``"work rate"`` of the muscles, :math:`\sqrt{(\tau \dot q)^2 + \epsilon^2} - \epsilon`;
    - ``"joint torque"``, muscles and tissue together, where tissue bears much
      (:attr:`ContactBody.stiff`);
    - ``"squared power"`` of the ankles' muscles, :math:`(\tau \dot q)^2`;
    - ``"endurance"``, :math:`(e^2 + \epsilon^2)^{3/4}` of the ankles' muscles: its square is about
      :math:`|e|^3`. With the ratio :math:`\kappa` of both strengths, :math:`e` goes smoothly from
      the torque :math:`\tau` to :math:`\kappa \tau` where the weaker muscles pull.

    All but the root are free until a term limits or weighs them.
    """
    sym = body.symbolic
    whole, functions = body.cache.get("dynamics", lambda: _functions(body))
    described = (  # name, names of rows, unit, what a row of 1 is in it
        ("root force", "xyz", "% of body weight", 100.0),
        ("root moment", "xyz", "% of body weight times metre", 100.0),
        ("muscle torque", sym.names[6:], "N m", body.torque),
        ("work rate", sym.names[6:], "W", body.torque),
        ("joint torque", body.stiff, "N m", body.torque),
        ("endurance", _ankles(body), "", 1.0),
        ("squared power", _ankles(body), "", 1.0),
    )
    families = []
    for (name, of, unit, size), function in zip(described, functions, strict=True):
        joined = f"{name} " if of == "xyz" else f"{name} of "
        names = tuple(joined + n for n in of)
        families.append(
            ConstraintFamily.free(name, function, names, n_nodes, parameters, unit, size)
        )
    for root in families[:2]:
        root.lower[:] = root.upper[:] = 0.0
    return ConstraintFamily.stacked("dynamics", whole, families)


def asked_by(
    body: ContactBody,
    q: Float[Array, "n nv"],
    v: Float[Array, "n nv"],
    a: Float[Array, "n nv"],
    force: Float[Array, "n n_forces"],
    times: Float[Array, " n"] | None = None,
) -> tuple[Float[Array, "n 6"], Float[Array, "n n_hinges"]]:
    """Return the wrench that a motion requires in addition to ground forces [body weights].

    It is the wrench at the pelvis [body weights, body weights · m], and torques of joints [N m].
    The function is that of :func:`dynamics`, which a solver has. Where something acts on the body
    from outside, ``times`` say when [s].
    """
    p = np.zeros((len(q), 0))
    if body.external.n_parameters:
        assert times is not None, "what acts from outside depends on time"
        p = body.external.parameters(times)
    whole, _ = body.cache.get("dynamics", lambda: _functions(body))
    rows = derivatives_of(whole).values(q, v, a, force, p)
    hinges = body.symbolic.names[6:]
    torques = rows[:, 6 : 6 + len(hinges)] * body.torque
    torques += np.stack(body.tissue(list(q[:, 6:].T), list(v[:, 6:].T)), axis=1)
    return rows[:, :6], torques


def _functions(body: ContactBody) -> "tuple[casadi.Function, list[casadi.Function]]":
    """Return the function of all rows, and those of each part."""
    import casadi as ca

    sym, k = body.symbolic, len(body.sites)
    external = body.external
    given = list(node_symbols(sym.nv, 3 * k, external.n_parameters))
    q, v, a, u, p = given
    forces = ca.reshape(u, 3, k) * body.weight
    points = [*body.sites, *(each.point for each in external.wrenches)]
    pushed = ca.horzcat(forces, *external.forces(p))
    tau = sym.inverse_dynamics(points)(q, v, external.in_space(a, p), pushed)
    tau = external.less_moments(sym, q, v, p, tau)
    helped = external.torques(sym.names[6:], q[6:], p, ca.sqrt)
    if helped:
        own = [tau[6 + i] - helped.get(i, 0.0) for i in range(sym.nv - 6)]
        tau = ca.vertcat(tau[:6], *own)
    muscle = tau[6:]
    if body.passive or body.braces:
        muscle = muscle - ca.vertcat(*body.tissue(q[6:], v[6:]))
    muscle = muscle / body.torque
    power = muscle * v[6:]
    work = ca.sqrt(power * power + WORK_RATE_ROUNDING**2) - WORK_RATE_ROUNDING
    joint = [tau[sym.names.index(n)] / body.torque for n in body.stiff]
    tired = [_endurance(ca, body, muscle, name) for name in _ankles(body)]
    parts = (
        tau[:3] / body.weight,
        tau[3:6] / body.weight,
        muscle,
        work,
        ca.vertcat(ca.SX(0, 1), *joint),
        ca.vertcat(ca.SX(0, 1), *tired),
        ca.vertcat(ca.SX(0, 1), *[power[body.human.hinge(n)] ** 2 for n in _ankles(body)]),
    )
    whole = ca.Function("rows", given, [ca.vertcat(*parts)])
    return whole, [ca.Function("rows", given, [part]) for part in parts]


def _ankles(body: ContactBody) -> tuple[str, ...]:
    """Return the ankles' hinges."""
    return tuple(n for n in body.symbolic.names[6:] if n.startswith("ankle_angle"))


def _endurance(ca: Any, body: ContactBody, muscle: Any, name: str) -> Any:
    """Return the row of one ankle."""
    i = body.human.hinge(name)
    weaker, stronger = body.human.model.jnt_actfrcrange[1 + i]
    ratio = abs(float(weaker / stronger))  # plantarflexors, negative, over dorsiflexors
    tau = muscle[i]
    e = tau * ((ratio + 1) / 2 + (ratio - 1) / 2 * tau / ca.sqrt(tau * tau + ANKLE_ROUNDING**2))
    square = e * e + ENDURANCE_ROUNDING**2
    return ca.sqrt(square * ca.sqrt(square))
