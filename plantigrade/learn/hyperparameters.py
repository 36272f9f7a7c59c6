"""Hyperparameters of proximal policy optimisation."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Learning:
    """How a policy learns: the networks of [Park2020]_, and what taught a walk in 10 minutes.

    Attributes:
        persons: How many walk at once.
        steps: Decisions of each between two updates.
        updates: Updates in a part.
        epochs: Passes over the decisions in an update.
        batch: Decisions in a gradient.
        gamma: Discount of a decision later.
        trace: λ of the generalised advantage.
        clip: By which the ratio of probabilities may change.
        rate: Learning rate of the actor to begin with; it follows the divergence.
        judging: That of the critic, always the same; that of the actor if absent.
        divergence: Wanted of the policies before and after an update.
        spread: Standard deviation of displacements to begin with [rad].
        layers: Neurons of the hidden layers, of actor and critic.
        starts: From how many instants of the stride the goal is looked at.
        patience: Parts between two looks.
        listening: Parts in which only the critic learns, where a policy is there to begin with.
    """

    persons: int = 64
    steps: int = 64
    updates: int = 5
    epochs: int = 5
    batch: int = 1024
    gamma: float = 0.97
    trace: float = 0.95
    clip: float = 0.2
    rate: float = 1e-4
    judging: float | None = None
    divergence: float = 0.02
    spread: float = 0.11
    layers: tuple[int, ...] = (256, 128, 128)
    starts: int = 16
    patience: int = 4
    listening: int = 1

    @property
    def part(self) -> int:
        """Decisions in a part."""
        return self.persons * self.steps * self.updates


GOING_ON = Learning(divergence=0.03, judging=1e-3)
"""Of who begins with a policy: the critic, which knows nothing, learns before that changes."""
