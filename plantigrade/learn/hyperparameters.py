"""Hyperparameters of proximal policy optimisation."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Hyperparameters:
    """Hyperparameters, with the networks of [Park2020]_; enough for a walk within 10 minutes."""

    persons: int = 64  #: Number of parallel environments
    steps: int = 32  #: Decisions per environment between two updates
    updates: int = 10  #: Updates per part
    epochs: int = 5  #: Passes over the decisions per update
    batch: int = 1024  #: Decisions per gradient step
    gamma: float = 0.97  #: Discount factor
    gae_lambda: float = 0.95  #: λ of the generalised advantage estimate
    clip: float = 0.2  #: Clip range of the probability ratio
    rate: float = 1e-4  #: Initial learning rate of the actor; it is adapted to the divergence
    #: Constant learning rate of the critic. With that of the actor it explains 85 % of the variance
    #: of the returns after 100 000 decisions in place of 93 %.
    critic_rate: float = 1e-3
    target_kl: float = 0.02  #: Desired Kullback-Leibler divergence of an update
    action_std: float = 0.11  #: Initial standard deviation of displacements [rad]
    layers: tuple[int, ...] = (256, 128, 128)  #: Neurons of the hidden layers of actor and critic
    evaluation_starts: int = 16  #: Number of initial phases of an evaluation
    evaluation_interval: int = 4  #: Parts between two evaluations
    #: Parts in which only the critic learns, if training starts from a policy
    critic_warmup: int = 1

    @property
    def part(self) -> int:
        """Decisions per part."""
        return self.persons * self.steps * self.updates


FINE_TUNING = Hyperparameters(steps=64, updates=5, target_kl=0.03, action_std=0.07)
"""For training that starts from a policy; the untrained critic learns first. Larger noise makes
landings harder than the policy does: forces within decisions then say little about it."""
