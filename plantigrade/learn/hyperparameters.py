"""Hyperparameters of proximal policy optimisation."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Hyperparameters:
    """Hyperparameters, with the networks of [Park2020]_; they suffice for a walk within 10 minutes.

    Attributes:
        persons: Number of parallel environments.
        steps: Decisions per environment between two updates.
        updates: Updates per part.
        epochs: Passes over the decisions per update.
        batch: Decisions per gradient step.
        gamma: Discount factor.
        gae_lambda: λ of the generalised advantage estimate.
        clip: Clip range of the probability ratio.
        rate: Initial learning rate of the actor; it is adapted to the divergence.
        critic_rate: Constant learning rate of the critic; that of the actor if absent.
        target_kl: Desired Kullback-Leibler divergence of an update.
        action_std: Initial standard deviation of displacements [rad].
        layers: Neurons of the hidden layers of actor and critic.
        evaluation_starts: Number of initial phases of an evaluation.
        evaluation_interval: Parts between two evaluations.
        critic_warmup: Parts in which only the critic learns, if training starts from a policy.
    """

    persons: int = 64
    steps: int = 64
    updates: int = 5
    epochs: int = 5
    batch: int = 1024
    gamma: float = 0.97
    gae_lambda: float = 0.95
    clip: float = 0.2
    rate: float = 1e-4
    critic_rate: float | None = None
    target_kl: float = 0.02
    action_std: float = 0.11
    layers: tuple[int, ...] = (256, 128, 128)
    evaluation_starts: int = 16
    evaluation_interval: int = 4
    critic_warmup: int = 1

    @property
    def part(self) -> int:
        """Decisions per part."""
        return self.persons * self.steps * self.updates


FINE_TUNING = Hyperparameters(target_kl=0.03, critic_rate=1e-3)
"""For training that starts from a policy; the untrained critic learns first."""
