"""Tolerances of the check: the discretisation error between the nodes of a spline, and no more."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tolerances:
    """Largest errors of a motion that still counts as physical.

    Body weight is mass times gravity; "percent of body weight times metre" is the moment of a
    hundredth of it at one metre.
    """

    #: Unexplained force at the root, root mean square [% of body weight]
    root_force_rms: float = 0.5
    root_force_max: float = 1.0  #: The same at any instant
    #: Unexplained moment about the centre of mass, root mean square [% of body weight times
    #: metre]
    root_moment_rms: float = 0.5
    root_moment_max: float = 1.0  #: The same at any instant
    #: Distance the material at a standing site moves along the ground in one stance [mm]
    slip: float = 3.0
    slip_speed: float = np.inf  #: Its speed at any instant [m/s]; infinite: reported, not judged
    penetration: float = 2.0  #: Depth of any contact sphere in the ground [mm]
    hover: float = 2.0  #: Height of a standing site above the ground [mm]
    #: By how much tangential over normal force may exceed the coefficient of friction
    friction: float = 0.01
    #: Normal force below which the ratio is taken over this force instead [% of body weight]
    negligible: float = 1.0
    adhesion: float = 0.1  #: Pull of the ground [% of body weight]
    overlap: float = 2.0  #: Depth of one part of the body in another, where that is judged [mm]
    pressure: float = 3.0  #: Distance of a centre of pressure from the base of support [mm]
    unsupported: float = 0.1  #: Force of a site that does not stand [% of body weight]
    force: float = 1.0  #: Excess over the greatest normal force of a site [% of that limit]
    coordinate: float = 0.5  #: Excess over the limit of a joint [deg]
    velocity: float = 2.0  #: Excess over the limit of a joint's speed [% of that limit]
    torque: float = 2.0  #: Excess over the limit of a joint's torque [% of that limit]
    #: Difference between given velocity and rate of position, in percent of the coordinate's
    #: greatest speed (but of no less than 1 rad/s or 0.5 m/s)
    velocity_mismatch: float = 0.5
    #: Likewise of accelerations (no less than 10 rad/s² or 3 m/s²)
    acceleration_mismatch: float = 5.0
    #: Force, and moment over one metre, by which the rate of momentum differs from the external
    #: forces, mean over a step [% of body weight]
    momentum: float = 2.0
    #: Power by which the rate of energy differs from that of the joints, mean over a step, in
    #: percent of its greatest value (but of no less than body weight times 1 m/s)
    energy: float = 5.0
    condition_deg: float = 0.5  #: Violation of a task's condition on an angle [deg]
    condition_mm: float = 2.0  #: On a place or distance [mm]
    clearance: float = 5.0  #: On the height of a swinging foot, which may dip but not touch [mm]
    condition_rad_s: float = 0.05  #: On an angular velocity [rad/s]
    condition_m_s: float = 0.02  #: On a velocity [m/s]
    condition_w: float = 1.0  #: On a power [W]


OF_RECORDING = Tolerances(
    root_force_rms=5.0,
    root_force_max=20.0,
    root_moment_rms=5.0,
    root_moment_max=10.0,
    momentum=20.0,
)
"""What is allowed where the forces are those of a recording, measured or estimated.

They are not made to explain the motion exactly: a plate knows nothing of the fitted body, and an
estimate that met every acceleration would put the noise of the motion into the forces. A force of
5 % of the peak reaction may be left over [Hicks2015]_; so may the moment of a centre of mass
that is misjudged by 5 cm, of which estimated forces take one constant part as unknown.
"""
