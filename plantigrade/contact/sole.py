r"""How soles yield: heel pads, soft tissue of the lower leg and shoes, as springs and dampers.

A spring and a damper under a sphere, taken implicitly over a time step :math:`h`,

.. math:: f = -K (r + h v + h^2 a) - D (v + h a),

with the distance :math:`r` from the ground, its rate :math:`v` and acceleration :math:`a`, are a
contact of MuJoCo, :math:`R f = a_{ref} - a` with :math:`a_{ref} = -b v - k r`, for

.. math:: 1 / R = K h^2 + D h, \qquad k = K R, \qquad b = (D + K h) R .
"""

from dataclasses import dataclass

import mujoco

from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.site import GEOM_PREFIX, contact_sites
from plantigrade.models import Human

IMPEDANCE_WIDTH = 0.001  # [m] depth over which impedances change in MuJoCo; these are constant
SOLE_SHARE = 1e6  # of a sole in a contact by that of the ground, which has friction of its own


@dataclass(frozen=True, kw_only=True)
class SoleSettings:
    """How the spheres under the feet yield, all alike."""

    stiffness: float = 450.0
    """Stiffness of all spheres of a foot together [body weights per metre]: 350 kN/m for 80 kg, and
    100 kN/m for the two of seven under a heel, which body weight presses in by 8 mm, about as far
    as people's steps press their heel pads [Wearing2014]_. That is a secant: pads start softer and
    end stiffer, at 150 kN/m with the lower leg [Aerts1995]_, whose yielding, like that of the arch,
    rigid segments lack. Pushed people landed with 3.5 body weights on average, and 8 at most, with
    twice this stiffness, 2.7 and 6 with this; with the usual contacts of MuJoCo, 20."""
    damping_time: float = 0.01
    """Damping by stiffness [s]: foot and shank, some 5 kg, do not rebound; heel pads lose most of
    the energy of a step [Wearing2014]_."""
    friction_ratio: float = 100.0
    """Stiffness of friction by that of the soles: under a shear of a fifth of body weight a sole
    creeps by less than a millimetre per second."""


def soften_soles(model: mujoco.MjModel, human: Human, settings: SoleSettings) -> None:
    """Let the soles of a person in a MuJoCo model yield; the time step must be set.

    Args:
        model: The model, with a contact sphere for each site of the feet; changed.
        settings: Stiffness and damping.
    """
    sites = contact_sites(human)
    stiffness = settings.stiffness * human.mass * GRAVITY * len(SIDES) / len(sites)
    for site in sites:
        soften(model, site.name, stiffness, settings.damping_time)
    model.opt.impratio = settings.friction_ratio


def soften(model: mujoco.MjModel, site: str, stiffness: float, damping_time: float) -> None:
    """Let the sphere of a contact site yield like a spring and a damper.

    Args:
        model: The model, with its time step; changed.
        site: Name of the site.
        stiffness: Stiffness of the spring [N/m].
        damping_time: Damping by stiffness [s].
    """
    step, damping = model.opt.timestep, damping_time * stiffness
    inertia = stiffness * step**2 + damping * step
    geom = model.geom(GEOM_PREFIX + site)
    ratio = float(model.body_invweight0[geom.bodyid[0], 0]) * inertia
    impedance = ratio / (1.0 + ratio)
    unit = impedance / inertia
    geom.solref[:] = -unit * stiffness, -unit * (damping + step * stiffness)
    geom.solimp[:] = impedance, impedance, IMPEDANCE_WIDTH, 0.5, 2.0
    geom.solmix[:] = SOLE_SHARE
