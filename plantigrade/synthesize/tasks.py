"""Tasks by name: what the command line and task files know."""

from collections.abc import Callable, Mapping

from plantigrade.models import Human
from plantigrade.synthesize.contact_plan import ContactPlan, foot_sites
from plantigrade.synthesize.formulation import Body
from plantigrade.synthesize.side_step import side_step
from plantigrade.synthesize.standing_tasks import reach, sit_to_stand, squat
from plantigrade.synthesize.task import Task
from plantigrade.synthesize.walking import walk


def stand_to_sit(human: Human, **parameters: float) -> Task:
    """Return the task of sitting down, the reverse of rising from a chair."""
    return sit_to_stand(human, **parameters, reverse=True)


TASKS: Mapping[str, Callable[..., Task]] = {
    "walk": walk,
    "sit-to-stand": sit_to_stand,
    "stand-to-sit": stand_to_sit,
    "squat": squat,
    "reach": reach,
    "side-step": side_step,
}
"""Name of a task → function of a person and the task's parameters."""


def body_for(human: Human, plan: ContactPlan) -> Body:
    """Return a person with all places that carry force in a plan: both feet, and its supports."""
    places = {s.site.name: s.site for s in plan.supports}
    return Body.of(human, (*foot_sites(human), *places.values()))
