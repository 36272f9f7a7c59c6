"""A controller of your own: a person bows a little, is pushed, and stays on the feet."""

import plantigrade as pg
import plantigrade.world as world


def bow(state):
    """Bend the hips over two seconds, and say how high the centre of mass is."""
    memory, human = state.world.memory, state.human
    if state.time == 0.0:
        memory["start"] = state.angles.copy()
    target = memory["start"].copy()
    for side in ("r", "l"):
        bend = 0.15 * min(state.time / 2.0, 1.0)
        target[human.hinge(f"hip_flexion_{side}")] += bend
        target[human.hinge(f"ankle_angle_{side}")] -= 0.3 * bend
    return world.StablePD(target, signals={"com_height": state.body.com[2]})


run = pg.simulate(controller=bow, duration=3.0, push=("30,0.1,90,2.2",))
print(f"status: {run.status}")
print(f"centre of mass at {run.record.signals['controller.com_height'][-1]:.2f} m")
print(f"motors up to {run.figures['motor_torque_max_pct']:.0f} % of the joints' strength")
print("report:", run.report())
