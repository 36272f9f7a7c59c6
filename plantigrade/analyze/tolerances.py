"""Tolerances of the check, sized for the discretisation error between the nodes of a spline."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tolerances:
    """Maximum errors of a motion that counts as physical.

    Body weight is mass times gravity; "percent of body weight times metre" is the moment of 1 % of
    it at one metre.
    """

    #: RMS residual force at the root [% of body weight]
    root_force_rms: float = 0.5
    root_force_max: float = 1.0  #: Maximum at any instant
    #: RMS residual moment about the centre of mass [% of body weight times metre]
    root_moment_rms: float = 0.5
    root_moment_max: float = 1.0  #: Maximum at any instant
    #: Slip of a site in one stance [mm]
    slip: float = 3.0
    slip_speed: float = np.inf  #: Slip speed [m/s]; infinite, so it is reported only
    penetration: float = 2.0  #: Depth of any contact sphere in the ground [mm]
    hover: float = 2.0  #: Height of a site in stance above the ground [mm]
    #: Excess of tangential over normal force above the coefficient of friction
    friction: float = 0.01
    #: Minimum normal force in that ratio [% of body weight]
    negligible: float = 1.0
    adhesion: float = 0.1  #: Tensile force of the ground [% of body weight]
    overlap: float = 2.0  #: Depth of one body part in another, if it is judged [mm]
    pressure: float = 3.0  #: Distance of a centre of pressure from the base of support [mm]
    unsupported: float = 0.1  #: Force of a site without stance [% of body weight]
    force: float = 1.0  #: Excess over the maximum normal force of a site [% of that limit]
    coordinate: float = 0.5  #: Excess over the limit of a joint [deg]
    velocity: float = 2.0  #: Excess over the limit of a joint's speed [% of that limit]
    torque: float = 2.0  #: Excess over the limit of a joint's torque [% of that limit]
    #: Difference between velocity and rate of position, in percent of the coordinate's maximum
    #: speed (at least 1 rad/s or 0.5 m/s)
    velocity_mismatch: float = 0.5
    #: The same for accelerations (at least 10 rad/s² or 3 m/s²)
    acceleration_mismatch: float = 5.0
    #: Force, and moment over one metre, by which the rate of momentum differs from the external
    #: forces, mean over a step [% of body weight]
    momentum: float = 2.0
    #: Power by which the rate of energy differs from that of the joints, mean over a step, in
    #: percent of its maximum (at least body weight times 1 m/s)
    energy: float = 5.0
    condition_deg: float = 0.5  #: Violation of a task's condition on an angle [deg]
    condition_mm: float = 2.0  #: On a position or distance [mm]
    clearance: float = 5.0  #: On the height of a swing foot, which may dip but not touch [mm]
    condition_rad_s: float = 0.05  #: On an angular velocity [rad/s]
    condition_m_s: float = 0.02  #: On a velocity [m/s]
    condition_w: float = 1.0  #: On a power [W]
    condition_n_m: float = 0.5  #: On a torque of muscles [N m]


RECORDING_TOLERANCES = Tolerances(
    root_force_rms=5.0,
    root_force_max=20.0,
    root_moment_rms=5.0,
    root_moment_max=10.0,
    momentum=20.0,
)
"""Tolerances for recordings with measured or estimated forces.

These forces do not explain the motion exactly: plates are independent of the fitted body, and an
estimate that met every acceleration would contain the noise of the motion. A residual force of 5 %
of the peak reaction is acceptable [Hicks2015]_, and the moment of an error of 5 cm in the centre of
mass, a constant part of which is unknown to estimated forces.
"""
