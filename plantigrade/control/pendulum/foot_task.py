"""A foot of a walk as a whole-body task."""

from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.wbc.tasks import Task
from plantigrade.wbc.tasks.task import Target


class FootTask(Task):
    """Position or rotation of a foot.

    Args:
        part: Which rows of the motion of its body: rotation, or position.
        stiffness: Stiffness, critically damped [1/s²].
        weight: Root of the cost of a squared unit missed.
    """

    points: RigidPoints

    def __init__(self, part: slice, stiffness: float, weight: float):
        super().__init__("foot", stiffness=stiffness, weight=weight**2)
        self.part = part

    def of(self, points: RigidPoints, i: int, target: Target) -> "FootTask":
        """Return the task of a foot.

        Args:
            i: Which of them.
            target: Error that is left to undo, target velocity and target acceleration.
        """
        self.points, self._body, self.target = points, points.owner[i], target
        return self

    def error(self, state, time):
        """Return the error."""
        return -self.aim(time)[0]

    def jacobian(self, state, time):
        """Return the Jacobian of the foot."""
        return self.points.body_jacobian[self._body, self.part]

    def velocity(self, state, time, jacobian=None):
        """Return its velocity."""
        return self.points.body_velocity[self._body, self.part]

    def bias_acceleration(self, state, time):
        """Return its acceleration where nothing accelerates."""
        return self.points.body_bias[self._body, self.part]
