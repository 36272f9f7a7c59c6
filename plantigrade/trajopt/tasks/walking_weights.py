"""Weights of the cost of walking: one set for every speed, person, foot and direction."""

from dataclasses import dataclass


@dataclass(frozen=True)
class WalkingWeights:
    """Weights of the cost of walking, relative to that of hip torques, which is 1.

    Settled on half of the norms, as Gauss and Newton would, at 0.7, 1.3 and 1.9 m/s together:
    children at very slow, free and very fast speed [Schwartz2008]_ and moments of 69 adults
    [VanCriekinge2023]_ (``plantigrade experiment walk-norms``). The sensitivity is by how much the
    difference from these people, in goals, changes where the weight grows by a factor of e.
    """

    knee_torque: float = 1.75
    """Squared knee torque [1]: moment arms are about 4 cm at the knee and 6 cm at the hip
    [Rajagopal2016]_, which would be 2.25; the same torque takes 1.2 times the force."""
    trunk_torque: float = 4.0
    """Squared torque of the joints of the trunk [1]."""
    ankle_endurance: float = 0.42
    """Third power of ankle torque [1/s]."""
    work: float = 0.36
    """Positive and negative work of muscles [per 100 J]."""
    ankle_power: float = 0.14
    """Fourth power of the power of the muscles at the ankle, multiplied by that of the step time
    [per (100 W)⁴ s⁵]: faster steps are made by faster fibres. Settled with the shares of hip, knee
    and ankle in the work up a slope of 9° in view [Montgomery2018]_: the second power, weighted so
    that the shares uphill are people's, takes the ankle at 1.6 m/s further from theirs."""
    force_rate: float = 3.4e-3
    """Rates of contact forces, multiplied by the square of the step time [1/s]: muscles take 50 to
    100 ms to build up and to release force. More of it takes rise from the centre of mass."""
    jerk: float = 7.5e-8
    """Knee jerk, divided by the sixth power of the step time [1/(s rad²)]."""
    trunk_acceleration: float = 1.28e-3
    """Angular acceleration of the pelvis about the vertical and of the trunk's joints in extension
    [s³/rad²]. The pelvis turns in slow steps too, and not the more the faster they are; a cost of
    its speed would leave nothing of the ±4° that people have at 0.7 m/s. Below a trunk whose joints
    bend freely it rocks against its course in people, below one that goes along with it as theirs.
    """
    trunk_lean: float = 1.0
    """Sideways lean of the trunk [1/s]; the norms do not tell. People lean by ±1.6° ± 0.7°
    [Chung2010]_, this trunk by ±1.2° to ±2.1°, and by less than 3° on joint sets of one joint.
    Chosen: with 5, a person with 20 kg in one hand leans away from it by 2° in place of 4°."""
    trunk_pitch: float = 1.0
    """Lean of the trunk forward or back [1/s]; unloaded walks lean by 1° and do not tell. Chosen:
    with 5, a person with a rucksack of 20 kg leans forward by 2° in place of 11°."""
    thorax_extension: float = 5.0
    """Extension or flexion of the thorax on the lumbar spine away from standing [1/(s rad²)]. From
    standing people extend it by 8.7° ± 3.7° and flex it by 11.5° ± 3.7° [Edmondston2011]_. Chosen:
    unloaded walks stay within 1°; with 0.5, a person with 20 kg in one hand bends back by 22° there
    and hangs a part of the load on the tissue of the spine."""
    frontal_momentum: float = 0.3
    """Angular momentum about the way [1/s]."""
    vertical_momentum: float = 0.2
    """Angular momentum about the vertical [1/s]."""
    pelvis_tilt: float = 5.0
    """Pelvis tilt away from its lean in standing [1/(s rad²)]."""
    arm_flexion: float = 0.15
    """Arms away from hanging [1/(s rad²)]."""
