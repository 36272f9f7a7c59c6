"""What the checker allows: discretisation error between the nodes of a spline, and not more."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tolerances:
    """How far a motion may be off and still be called physical.

    Body weight is mass times gravity; "percent of body weight times metre" is the moment of a
    hundredth of it at one metre.

    Attributes:
        root_force_rms: Unexplained force at the root, root mean square [% of body weight].
        root_force_max: The same at any instant.
        root_moment_rms: Unexplained moment about the centre of mass, root mean square
            [% of body weight times metre].
        root_moment_max: The same at any instant.
        slip: Distance the material at a standing site moves along the ground in one stance [mm].
        slip_speed: Its speed at any instant [m/s]; infinite: reported, not judged.
        penetration: Depth of any contact sphere in the ground [mm].
        hover: Height of a standing site above the ground [mm].
        friction: By how much tangential over normal force may exceed the coefficient of friction.
        negligible: Normal force below which the ratio is taken over this force instead
            [% of body weight].
        adhesion: Pull of the ground [% of body weight].
        pressure: Distance of a centre of pressure from the base of support [mm].
        unsupported: Force of a site that does not stand [% of body weight].
        force: Excess over the greatest normal force of a site [% of that limit].
        coordinate: Excess over the limit of a joint [deg].
        velocity: Excess over the limit of a joint's speed [% of that limit].
        torque: Excess over the limit of a joint's torque [% of that limit].
        velocity_mismatch: Difference between given velocity and rate of position, in percent of
            the coordinate's greatest speed (but of no less than 1 rad/s or 0.5 m/s).
        acceleration_mismatch: Likewise of accelerations (no less than 10 rad/s² or 3 m/s²).
        momentum: Force, and moment over one metre, by which the rate of momentum differs from the
            external forces, mean over a step [% of body weight].
        energy: Power by which the rate of energy differs from that of the joints, mean over a step,
            in percent of its greatest value (but of no less than body weight times 1 m/s).
        condition_deg: Violation of a task's condition on an angle [deg].
        condition_mm: On a place or distance [mm].
        clearance: On the height of a swinging foot, which may dip but not touch [mm].
        condition_rad_s: On an angular velocity [rad/s].
        condition_m_s: On a velocity [m/s].
        condition_w: On a power [W].
    """

    root_force_rms: float = 0.5
    root_force_max: float = 1.0
    root_moment_rms: float = 0.5
    root_moment_max: float = 1.0
    slip: float = 3.0
    slip_speed: float = np.inf
    penetration: float = 2.0
    hover: float = 2.0
    friction: float = 0.01
    negligible: float = 1.0
    adhesion: float = 0.1
    pressure: float = 3.0
    unsupported: float = 0.1
    force: float = 1.0
    coordinate: float = 0.5
    velocity: float = 2.0
    torque: float = 2.0
    velocity_mismatch: float = 0.5
    acceleration_mismatch: float = 5.0
    momentum: float = 2.0
    energy: float = 5.0
    condition_deg: float = 0.5
    condition_mm: float = 2.0
    clearance: float = 5.0
    condition_rad_s: float = 0.05
    condition_m_s: float = 0.02
    condition_w: float = 1.0
