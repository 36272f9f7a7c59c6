"""A whole-body controller of your own: a person is pushed with 60 N and stays on the feet."""

import numpy as np

import plantigrade as pg
import plantigrade.wbc as wbc
import plantigrade.world as world


class Stand:
    """Feet, centre of mass and posture by weight, within friction and the strength of joints."""

    def begin(self, body, actuators):
        """Take the first posture as the target."""
        self.program = wbc.WholeBody(body.human, armature=actuators.armature)
        self.feet = wbc.tasks.ContactTask.of(body.human, weight=1000.0)  # per (m/s²)², as the next
        self.com = wbc.tasks.ComTask(body.com, stiffness=50.0, weight=1000.0)  # 1/s²
        self.posture = wbc.tasks.PostureTask(body.qpos, stiffness=80.0, weight=1.0)

    def __call__(self, state):
        """Return the torques of one control step."""
        body, actuators, time = state.body, state.world.actuators, state.time
        if time == 0.0:
            self.begin(body, actuators)
        self.feet.begin(body, time)
        answer = self.program.solve(
            body,
            self.feet.touching(body, friction=0.6),
            [self.feet.rows(body, time), self.com.rows(body, time)],
            desired=self.posture.acceleration(body, time),
            weight=self.posture.weight,
            passive=actuators.passive(state.angles, state.rates),
        )
        return world.Torque(answer.torque, signals={"com": body.com - self.com.target})


run = pg.simulate(controller=Stand(), duration=3.0, push=("60,0.2,0,1",))
away = 100.0 * np.linalg.norm(run.record.signals["controller.com"], axis=1)
print(f"status: {run.status}")
print(f"centre of mass up to {away.max():.1f} cm away, {away[-1]:.1f} cm at the end")
