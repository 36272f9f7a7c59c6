"""Transfer of a policy to other feet, ground, pushes or another walk, as a start of training."""

import numpy as np

from plantigrade.arrays import Float, Int
from plantigrade.errors import ParameterError
from plantigrade.learn.policy import Policy
from plantigrade.learn.policy_interface import PolicyInterface
from plantigrade.learn.rules import Rules
from plantigrade.models import Human

Layers = tuple[tuple[Float[np.ndarray, "i o"], Float[np.ndarray, " o"]], ...]


def transfer_policy(
    policy: Policy, human: Human, rules: Rules
) -> tuple[Layers, Float[np.ndarray, " size"], Float[np.ndarray, " size"]]:
    """Return layers, mean and scale of a policy for a person with other feet or joints.

    Bodies, hinges and joints are matched by name. New observations have zero weight, and new
    actions are zero.
    """
    if {policy.rules.form, rules.form} != {"lean"}:
        raise ParameterError("a policy can start another one only if both have form='lean'")
    theirs, mine = (
        PolicyInterface(policy.reference.human, policy.rules),
        PolicyInterface(human, rules),
    )
    seen = _seen(list(policy.reference.human.body_names), list(human.body_names))
    done = _places(_names(policy.reference.human, theirs), _names(human, mine))
    weight, bias = policy.layers[0]
    first = (_taken(weight, seen), bias.copy())
    weight, bias = policy.layers[-1]
    last = (_taken(weight.T, done).T.copy(), _taken(bias, done))
    scale = _taken(policy.scale, seen)
    scale[seen < 0] = 1.0
    return (first, *policy.layers[1:-1], last), _taken(policy.mean, seen), scale


def _seen(theirs: list[str], mine: list[str]) -> Int[np.ndarray, " size"]:
    """Return the index of each new observation in the old ones; -1 if there is none."""
    n, blocks = len(theirs), 5
    place = _places(theirs, mine)
    found = [
        np.where(place[:, None] < 0, -1, 3 * (n * k + place)[:, None] + np.arange(3)).ravel()
        for k in range(blocks)
    ]
    return np.concatenate([*found, 3 * blocks * n + np.arange(9)])


def _names(human: Human, form: PolicyInterface) -> list[str]:
    """Return the name of each entry of an action."""
    hinges = [human.coordinates[i] for i in form.action.displaced]
    return [*hinges, *(f"stiffness of {name}" for name in form.action.joints)]


def _places(theirs: list[str], mine: list[str]) -> Int[np.ndarray, " k"]:
    """Return the index of each of my names in theirs; -1 if there is none."""
    return np.array([theirs.index(name) if name in theirs else -1 for name in mine])


def _taken(rows: np.ndarray, where: Int[np.ndarray, " k"]) -> np.ndarray:
    """Return rows by index, zeros for index -1."""
    found = rows[where].copy()
    found[where < 0] = 0.0
    return found
