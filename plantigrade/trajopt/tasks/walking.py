"""Walking as a task: periodic, or from standing to standing; straight, turning, up and down.

The cost is the same at every speed, for every person and every foot; the weights are
:class:`~plantigrade.trajopt.tasks.walking.WalkingWeights`:

- muscle torques squared (Eq. 15 of [Zhakatayev2023]_), of the knee, whose muscles pull at shorter
  arms, and of the trunk more;
- of the ankle the third power instead, by the strength of the muscles that make the torque, as
  endurance goes [Crowninshield1981]_; short fibres on a long tendon make it cheap [Griffin2003]_;
- positive and negative work of muscles, and the fourth power of power at the ankle: its fibres are
  the shortest of the leg [Rajagopal2016]_, and work of a muscle that shortens fast takes more
  [Hill1938]_. With a cost of work alone ankles do most of the work uphill;
- jerk, of every part by its inertia [Biess2007]_ and in the time of a step [Hogan2009]_: a slow
  walk is as smooth as a fast one is, so that its jerk costs more; and rates of contact forces. Both
  keep splines and forces smooth between nodes, and hold the centre of mass down;
- angular momentum about the centre of mass, in the frontal plane and about the vertical, which
  people keep small [Herr2008]_: it brings the swing of the arms and the thorax that turns against
  the pelvis;
- lean of head and trunk in space, turning of the trunk off the way, and how fast the pelvis'
  turning about the vertical changes, and the extension of the trunk [Pozzo1990]_, [Winter1995]_. A
  cost of the pelvis' angles instead takes the one wave a stride away that people have and leaves
  the faster ones that they do not; one of its angular velocity leaves nothing of it in slow walks;
- the pelvis' lean away from that in standing, and extension of the thorax, whose range is small;
  weakly, bending of the other joints of the trunk, and the arms away from hanging.

Legs and arms are solid, legs pass each other with a margin, and the plan uses no more friction than
people do [Fong2009]_.

The weights were settled on half of the norms of walking; the problem itself contains no recording
and no norm.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.contact.ground import FOOT_AHEAD_OF_ANKLE, FOOT_BEHIND_ANKLE
from plantigrade.contact.limb_sites import REFERENCE_HEIGHT, palm
from plantigrade.contact.plan import ContactPlan, Obstacle
from plantigrade.data_files import named_numbers
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt.guess.walk import walking_guess
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.tasks.gait_parameters import GaitParameters, gait_parameters
from plantigrade.trajopt.tasks.gait_settings import WalkSettings
from plantigrade.trajopt.tasks.mechanics import check_froude, check_support
from plantigrade.trajopt.tasks.task import Guess, MotionTask
from plantigrade.trajopt.tasks.walking_plan import periodic_walk_plan, walk_plan
from plantigrade.trajopt.terms.contact import Clearance, Contact, Dynamics, Forces
from plantigrade.trajopt.terms.effort import Acceleration, AnklePower, Endurance, Jerk, Torque, Work
from plantigrade.trajopt.terms.external import Hold, Wrench
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.terms.momentum import AngularMomentum
from plantigrade.trajopt.terms.obstacle import StepOver
from plantigrade.trajopt.terms.posture import Posture, PostureAt, Quiet, Rest, Upright
from plantigrade.trajopt.terms.solid import SolidLimbs
from plantigrade.trajopt.terms.term import Term


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


MIN_LEG_DISTANCE = 0.025
"""Distance of the legs in passing [m]; the SD of step width of young adults is 2.1 to 2.5 cm
[Skiadopoulos2020]_, and closer legs would often touch."""
PELVIS_LEAN = 0.12
"""Forward lean of the pelvis in standing, from the zero of ``pelvis_tilt`` [rad]. The plane of its
spines leans by about 10° in people who stand [Levine1996]_ and who walk [Fukuchi2018]_, by 2.7° at
the zero. The spine straightens up above it."""
WEIGHTS = WalkingWeights()
TRUNK = tuple(
    f"{part}_{way}" for part in ("lumbar", "thorax") for way in ("extension", "bending", "rotation")
)
USED_FRICTION = 0.35  # Coefficient of friction of a walk's plan [1]; higher on slopes
UPRIGHT_WEIGHTS = named_numbers("plantigrade.trajopt.tasks", "upright_weights.csv")
"""Weights of an upright trunk and head and hanging arms [1/(s rad²)]."""

STANDING_POSTURE = {
    "lumbar_extension": PELVIS_LEAN / 2,
    "thorax_extension": PELVIS_LEAN / 2,
    "elbow_flex": 0.35,
    "pro_sup": 1.4,
    "arm_add": -0.14,
}
"""Postures that are not zero [rad]."""

HANDLE_HEIGHT = 1.05
"""Height of the handle of a cart [m]; shopping trolleys and beds have 0.95 to 1.1 m."""
HANDLE_AHEAD = 0.45
"""Distance of the handle ahead of the pelvis [m]."""
ARMS_AHEAD = {"arm_flex": float(np.deg2rad(25.0)), "elbow_flex": float(np.deg2rad(65.0))}
"""Angles of the arms in the guess of a walk with a cart [rad]."""
CROSSING_SLOWNESS = 1.25
"""How much longer a step over a block lasts, relative to block height over leg length [1]: people
cross at .80, .70 and .64 m/s where it is 10, 20 and 30 % of the leg, with equal steps
[Kuo2022]_."""
OBSTACLE_SHARE = 0.6
"""Distance of the toes before a block, relative to the room of toes and heel around it [1]: 25 and
16 % of the leg [Kuo2022]_."""
CLEARANCE = 0.01  # [m] clearance of the foot in mid-swing
TOLERANCE = 1e-4
"""Error of the optimality conditions at which a periodic walk is solved [1]: at 1e-3, three
iterations less, joint angles are still up to 1.5° RMS from the optimum, towards the guess."""
NODES_PER_SECOND = {True: 60.0, False: 20.0}
"""Nodes per second up to :data:`USUAL_SPEED`, periodic and from standing; proportionally more
above, and more with loads (:func:`finer_for_loads`)."""
LIMB_ENDS = {"hand": 0.014, "foot": 0.035}
"""Mass of hand or foot and half of the segment above it, by body mass [1] [deLeva1996]_."""

USUAL_SPEED = 1.3
"""Usual walking speed [m/s]."""


def walking_terms(step_time: float, slope: float = 0.0) -> tuple[Term, ...]:
    """Return conditions and costs of every walk, by the time of a step [s] and on a slope [rad]."""
    weights = WEIGHTS
    torques = {"ankle_angle": 0.0, "knee_angle": weights.knee_torque}
    torques |= dict.fromkeys(TRUNK, weights.trunk_torque)
    upright = {
        "pelvis_tilt": weights.pelvis_tilt,
        "thorax_extension": weights.thorax_extension,
        "arm_flex": weights.arm_flexion,
    }
    steady = ("pelvis_rotation", *(n for n in TRUNK if n.endswith("_extension")))
    return (
        Dynamics(),
        Contact(used=USED_FRICTION + abs(float(np.tan(slope)))),
        Clearance(CLEARANCE),
        Limits(),
        # The hands of a walker are far above the ground.
        SolidLimbs(MIN_LEG_DISTANCE, ground=np.inf, loads_beside=True),
        Torque(1.0, torques),
        Endurance(weights.ankle_endurance),
        Work(weights.work),
        AnklePower(weights.ankle_power * step_time**4),
        Jerk(weights.jerk * step_time**6, by_inertia=True),
        Acceleration(weights.trunk_acceleration, dict.fromkeys(steady, 1.0), others=0.0),
        Forces(rate=weights.force_rate * step_time**2),
        AngularMomentum(forward=weights.frontal_momentum, upward=weights.vertical_momentum),
        Upright("head", forward=1.0, sideways=3.0, turning=0.05),
        Upright("trunk", forward=weights.trunk_pitch, sideways=weights.trunk_lean, away=1.2),
        Posture(
            {**UPRIGHT_WEIGHTS, **upright},
            {**STANDING_POSTURE, "pelvis_tilt": -PELVIS_LEAN - slope},
        ),
    )


def walk(human: Human, parameters: WalkSettings) -> MotionTask:
    """Return the task of walking.

    Raises:
        ParameterError: If a value is out of range for this person, or mechanics rules it out.
    """
    check_froude(human, parameters.speed)
    p = gait_parameters(
        human, parameters.speed, step_length=parameters.step_length, cadence=parameters.cadence
    )
    if parameters.periodic:
        task = periodic_walk(human, p, slope=parameters.slope)
        if not parameters.cart_force:
            return task
        pushing = task.with_terms(*cart_terms(human, p, parameters.cart_force))
        return replace(pushing, guess=_arms_ahead(task.guess))
    heights = parameters.heights
    if parameters.step_height:
        # the last step closes, beside the one before it, and is as high
        first = min(parameters.steps // 2, parameters.steps - 2)
        heights = tuple(parameters.step_height * (k >= first) for k in range(parameters.steps))
    delays = crossing_delays(p, parameters.steps, parameters.obstacle_height)
    plan = walk_plan(
        human, p, steps=parameters.steps, turn=parameters.turn, heights=heights, delays=delays
    )
    check_support(human, plan)
    plan = replace(plan, slope=parameters.slope)
    if parameters.obstacle_height:
        plan = replace(plan, obstacles=(obstacle(plan, parameters.obstacle_height),))

    ends = walking_guess(human, plan, p, np.array([0.0, plan.duration]))
    ends[:, 0] -= parameters.slope  # pelvis tilt: upright
    terms: list[Term] = [*walking_terms(p.step_time, parameters.slope)]
    if plan.obstacles:
        raised = {"opposite_thighs": True, "feet": True}
        terms = [replace(t, **raised) if isinstance(t, SolidLimbs) else t for t in terms]
        terms.append(StepOver())
    for time, q in zip((0.0, plan.duration), ends, strict=True):
        terms += [Rest(time), Quiet(time, 1e-4), PostureAt(time, tuple(q))]
    faster = max(1.0, parameters.speed / USUAL_SPEED)
    finer = finer_for_loads(human)
    rate = NODES_PER_SECOND[False] * max(faster, finer)
    least = NODES_PER_SECOND[False] * finer if finer > 1.0 else 0.0
    return MotionTask("walk", plan, tuple(terms), _guess(p), rate, least_nodes_per_second=least)


def finer_for_loads(human: Human) -> float:
    """Return how many times more nodes a person with loads takes than one without [1].

    Forces that are missing between nodes go with the square of the distance of nodes and with the
    mass that moves. The ratio of nodes is therefore the root of that of the masses at the end of a
    limb (:data:`LIMB_ENDS`), with and without the load. On a mesh that is too coarse the arm is
    whirled between nodes, and its load seems to weigh less at them.
    """
    ratios = [
        mass / (LIMB_ENDS[place[:-2]] * human.mass)
        for place, mass in human.loads.items()
        if place[:-2] in LIMB_ENDS
    ]
    return float(np.sqrt(1.0 + max(ratios, default=0.0)))


def crossing_delays(p: GaitParameters, steps: int, height: float) -> list[float]:
    """Return how much longer each step lasts because both feet pass over a block [s]."""
    longer = CROSSING_SLOWNESS * height / p.leg_length * p.step_time
    first = (steps - 1) // 2
    return [longer if k in (first, first + 1) else 0.0 for k in range(steps)]


def obstacle(plan: ContactPlan, height: float) -> Obstacle:
    """Return a block of a height [m] on a straight way, between the middle two footprints."""
    places = sorted({s.footprint.position[0] for s in plan.stances})
    behind = (len(places) - 1) // 2
    toes = places[behind] + FOOT_AHEAD_OF_ANKLE
    heel = places[behind + 1] - FOOT_BEHIND_ANKLE
    block = Obstacle(0.0, height)
    room = heel - toes - block.width
    if room < 0.0:
        raise ParameterError(
            f"steps of {places[behind + 1] - places[behind]:.2f} m leave no room for a block of "
            f"{block.width:g} m between two footprints: give a higher speed or a longer step_length"
        )
    return replace(block, x=toes + OBSTACLE_SHARE * room + block.width / 2)


def periodic_walk(human: Human, parameters: GaitParameters, *, slope: float = 0.0) -> MotionTask:
    """Return the task of a periodic walk up a slope [rad], of which half a stride is solved."""
    plan = replace(periodic_walk_plan(human, parameters), slope=slope)
    usual = NODES_PER_SECOND[True] * max(1.0, parameters.speed / USUAL_SPEED)
    rate = max(usual, NODES_PER_SECOND[False] * finer_for_loads(human))
    terms = walking_terms(parameters.step_time, slope)
    return MotionTask("walk", plan, terms, _guess(parameters), rate, tolerance=TOLERANCE)


def cart_terms(human: Human, parameters: GaitParameters, force: float) -> tuple[Term, ...]:
    """Return hands on the handle of a cart at walking speed, and its force [N] on them."""
    terms: list[Term] = []
    d, size = human.dimensions, human.height / REFERENCE_HEIGHT
    ahead = HANDLE_AHEAD * size - parameters.step_length / 2
    for side, left in (("r", -1.0), ("l", 1.0)):
        point = palm(human, side)
        place = (ahead, left * d.shoulder_width / 2, HANDLE_HEIGHT * size)
        terms.append(Hold(point, place, (parameters.speed, 0.0, 0.0)))
        terms.append(Wrench(point, (-force / 2, 0.0, 0.0)))
    return tuple(terms)


def _arms_ahead(guess: Guess) -> Guess:
    """Return a guess whose hands are about on a handle; from hanging arms none is found."""

    def ahead(body: ContactBody, plan: ContactPlan, times: Array) -> Array:
        q = guess(body, plan, times)
        for side, (name, angle) in product(SIDES, ARMS_AHEAD.items()):
            q[:, 6 + body.human.hinge(f"{name}_{side}")] = angle
        return q

    return ahead


def _guess(parameters: GaitParameters) -> Guess:
    return lambda body, plan, times: walking_guess(body.human, plan, parameters, times)
