"""What one policy has learned as the beginning of another: other feet, ground, pushes, or walk."""

import numpy as np

from plantigrade.arrays import Float, Int
from plantigrade.errors import ParameterError
from plantigrade.learn.following import Form, Rules
from plantigrade.learn.policy import Policy
from plantigrade.models import Human

Layers = tuple[tuple[Float[np.ndarray, "i o"], Float[np.ndarray, " o"]], ...]


def carried_over(
    policy: Policy, human: Human, rules: Rules
) -> tuple[Layers, Float[np.ndarray, " size"], Float[np.ndarray, " size"]]:
    """Return layers, mean and scale of a policy for a person with other feet or joints.

    Bodies, hinges and joints are found by their names. What the policy did not see has no weight
    to begin with, and what it did not do is not done.

    Args:
        policy: The policy.
        human: The person.
        rules: Of the episodes to come.

    Raises:
        ParameterError: If one of them is not of the form ``"lean"``.
    """
    if {policy.rules.form, rules.form} != {"lean"}:
        raise ParameterError("a policy can start another one only if both have form='lean'")
    theirs, mine = Form(policy.reference.human, policy.rules), Form(human, rules)
    seen = _seen(list(policy.reference.human.body_names), list(human.body_names))
    done = _done(_names(policy.reference.human, theirs), _names(human, mine))
    weight, bias = policy.layers[0]
    first = (_taken(weight, seen), bias.copy())
    weight, bias = policy.layers[-1]
    last = (_taken(weight.T, done).T.copy(), _taken(bias, done))
    scale = _taken(policy.scale, seen)
    scale[seen < 0] = 1.0
    return (first, *policy.layers[1:-1], last), _taken(policy.mean, seen), scale


def _seen(theirs: list[str], mine: list[str]) -> Int[np.ndarray, " size"]:
    """Return where in what was seen each number of mine is; -1 where it is not."""
    n, blocks = len(theirs), 5
    place = np.array([theirs.index(name) if name in theirs else -1 for name in mine])
    found = [
        np.where(place[:, None] < 0, -1, 3 * (n * k + place)[:, None] + np.arange(3)).ravel()
        for k in range(blocks)
    ]
    return np.concatenate([*found, 3 * blocks * n + np.arange(9)])


def _names(human: Human, form: Form) -> list[str]:
    """Return what each number of an action is for."""
    hinges = [human.coordinates[i] for i in form.action.displaced]
    return [*hinges, *(f"stiffness of {name}" for name in form.action.joints)]


def _done(theirs: list[str], mine: list[str]) -> Int[np.ndarray, " k"]:
    return np.array([theirs.index(name) if name in theirs else -1 for name in mine])


def _taken(rows: np.ndarray, where: Int[np.ndarray, " k"]) -> np.ndarray:
    """Return rows by their places, zeros for those that are not there."""
    found = rows[where].copy()
    found[where < 0] = 0.0
    return found
