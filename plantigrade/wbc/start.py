"""How a motion begins: out of the ground, and with contacts that rest."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import State, integrate
from plantigrade.wbc.hierarchy import solve_hierarchy
from plantigrade.wbc.order import TaskOrder, scaled

# A direction in which a task moves less than this per unit of joint acceleration is singular: a
# straight knee lengthens the leg by nothing, and asking it to would ask for infinite speed. It also
# lets short toes give way a little where a foot rigid as a machine's would pull at the whole body:
# of contacts, turns of a segment that move its points by less per radian are not held.
SINGULAR = 0.02
ATTEMPTS = 10  # steps at most from a recorded posture to one that is not in the ground
LARGEST_STEP = 0.1  # of any coordinate in one of them [rad, m]
# How readily joints move in them: the foot before the leg, the leg before the rest of the body.
LIFTING = {("mtp", "cuboid_", "heel_"): 1.0, ("ankle_", "subtalar_"): 0.7, ("knee_", "hip_"): 0.5}
STAYS = 0.02  # how readily all other joints move in them


def first_state(state: State, order: TaskOrder, time: float) -> State:
    """Return the state a motion begins with: lifted out of the ground.

    A recorded posture has its feet some millimetres in the ground; a motion must not begin with a
    jump. Gauss-Newton steps, by the legs. (Feet above the ground come down by themselves.)
    """
    for task in order.tasks:  # an order may have moved somebody before
        task.reset()
    human, low, high = state.human, *state.human.limits
    share = np.full(len(state.qvel), STAYS)
    for i, name in enumerate(human.coordinates):
        share[6 + i] = next((s for words, s in LIFTING.items() if name.startswith(words)), STAYS)
    tasks = [task for task in order.tasks if task.initialises]
    for _ in range(ATTEMPTS):
        for task in tasks:
            task.begin(state, time)
        rows = [task.position_level(state, time) for task in tasks]
        lower, upper = np.full(len(share), -LARGEST_STEP), np.full(len(share), LARGEST_STEP)
        lower[6:] = np.clip(low - state.qpos[7:], -LARGEST_STEP, 0.0)
        upper[6:] = np.clip(high - state.qpos[7:], 0.0, LARGEST_STEP)
        levels = [scaled(row, share) for row in rows]
        bounds = {"lower": lower / share, "upper": upper / share}
        step = share * solve_hierarchy(levels, **bounds, singular=SINGULAR).x
        if np.abs(step).max() < 1e-6:
            break
        state = state.moved_to(integrate(state.model, state.qpos, step), state.qvel)
    for task in order.tasks:
        task.reset()
    return state


def velocity_after_impact(state: State, order: TaskOrder, time: float) -> Float[Array, " nv"]:
    r"""Return the velocity right after contacts have begun: an inelastic impact.

    The contacts stop their points, and the rest of the body changes its velocity as little as its
    inertia allows,

    .. math:: \min_{v^+} (v^+ - v^-)^T M (v^+ - v^-) .
    """
    wide = np.full(len(state.qvel), 1e4)
    return solve_hierarchy(
        [task.velocity_level(state, time) for task in order.tasks if task.causes_impact],
        lower=-wide,
        upper=wide,
        preferred=state.qvel,
        metric=state.mass_matrix,
        singular=SINGULAR,
    ).x
