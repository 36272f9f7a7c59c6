"""Proximal policy optimisation of a walk, by stable-baselines3.

Training consists of parts of a few updates. Every part restarts all episodes with random numbers of
its own, and its whole result is in the checkpoint. A training that was interrupted and resumed
therefore gives exactly the same policy as one that was not.
"""

import time as clock
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.errors import FileError, ParameterError
from plantigrade.extras import require
from plantigrade.io.writing import whole_file
from plantigrade.learn.elu import Elu
from plantigrade.learn.hyperparameters import FINE_TUNING, Hyperparameters
from plantigrade.learn.learning_curve import LearningProgress, write_curve
from plantigrade.learn.parallel_tracking import ParallelTracking
from plantigrade.learn.policy import OBSERVATION_CLIP, Policy, survival_times
from plantigrade.learn.rules import Rules
from plantigrade.learn.sb3_environment import TrainingEnvironment
from plantigrade.learn.shared_walks import SharedWalks
from plantigrade.learn.transfer import transfer_policy

_torch = require("torch", "learn")
_sb3 = require("stable_baselines3", "learn")
_vec = require("stable_baselines3.common.vec_env", "learn")
_utils = require("stable_baselines3.common.utils", "learn")

CHECKPOINT, POLICY, CURVE = "checkpoint.pt", "policy.npz", "curve.csv"
RATE_FACTOR = 1.5  # of one adaptation of the learning rate
MIN_RATE, MAX_RATE = 1e-5, 1e-3  # of learning
MAX_THREADS = 2  # of a gradient: halves of a batch sum to the same bits as the whole, thirds do not
MIN_TIME_BETWEEN_FALLS = 4.0  # [s] on average, before the policy is evaluated


class Training:
    """Training of a policy, with its files in a folder.

    Args:
        folder: Existing folder for checkpoint, curve and policy; an existing checkpoint is resumed.
        seed: Seed of all random numbers.
        goal: Walking time without a fall from every evaluation start at which training ends [s];
            zero for none.
        max_decisions: Maximum number of decisions.
        hyperparameters: Hyperparameters; by default those for training from scratch, or
            :data:`FINE_TUNING`.
        start: Initial policy, for any feet.
        jobs: Number of processes that simulate; the result does not depend on it.

    Raises:
        ParameterError: If the checkpoint belongs to another training.
        FileError: If it cannot be read.
        MissingExtra: If the extra is not installed.

    Attributes:
        curve: Learning curve.
        reached: Whether the goal is reached.
    """

    def __init__(
        self,
        rules: Rules,
        folder: str | Path,
        *,
        seed: int = 0,
        goal: float = 20.0,
        max_decisions: int = 3_000_000,
        hyperparameters: Hyperparameters | None = None,
        device: str = "cpu",
        start: Policy | None = None,
        jobs: int = 1,
    ):
        hyperparameters = hyperparameters or (Hyperparameters() if start is None else FINE_TUNING)
        self.folder, self.seed = Path(folder), seed
        self.goal, self.max_decisions = goal, max_decisions
        self.hyperparameters, self.reached = hyperparameters, False
        self.curve: list[LearningProgress] = []
        try:
            _torch.empty(0, device=device)
        except Exception as error:  # torch raises several kinds
            raise ParameterError(f"device={device!r}: {str(error)[:160]}") from error
        _torch.set_num_threads(min(jobs, MAX_THREADS))
        own = {f.name: getattr(rules, f.name) for f in fields(rules)}
        walks = SharedWalks(hyperparameters.persons, jobs, **own)
        self.tracking = walks.tracking
        self._environment = TrainingEnvironment(walks, 5.0 * (1.0 - hyperparameters.gamma))
        self._norm = _vec.VecNormalize(
            self._environment, norm_reward=False, clip_obs=OBSERVATION_CLIP
        )
        _utils.set_random_seed(seed)
        reach = self.tracking.action.reach
        self._learner = _learner(self._norm, hyperparameters, reach, device)
        self._learner.set_logger(_sb3.common.logger.Logger(None, []))
        self._rate, self._actor_learns = hyperparameters.rate, True
        self._evaluation: ParallelTracking | None = None
        self._start = start
        # An initial policy keeps its normalisation of observations.
        self._norm.training = start is None
        if (self.folder / CHECKPOINT).exists():
            self._resume(self.folder / CHECKPOINT)
        elif start is not None:
            self._start_from(start, walks)

    @property
    def decisions(self) -> int:
        """Number of decisions so far."""
        return self.curve[-1].decisions if self.curve else 0

    @property
    def network(self) -> Any:
        """Actor and critic as a torch module."""
        return self._learner.policy

    @property
    def finished(self) -> bool:
        """Whether training has ended."""
        return self.reached or self.decisions >= self.max_decisions

    def run(self, on_progress: Callable[[LearningProgress], None] = lambda _: None) -> Policy:
        """Train until the goal or the end, and return the policy, which is also in the folder."""
        while not self.finished:
            row = self.learn()
            self._save()
            on_progress(row)
        return self.policy()

    def close(self) -> None:
        """End the other processes."""
        self._environment.close()

    def learn(self) -> LearningProgress:
        """Do one part, and return how it went."""
        start_time, hyperparameters, learner = (
            clock.perf_counter(),
            self.hyperparameters,
            self._learner,
        )
        index, before = len(self.curve), self.curve[-1].seconds if self.curve else 0.0
        number = int(np.random.SeedSequence([self.seed, index]).generate_state(1)[0]) % 2**31
        _utils.set_random_seed(number)
        self._norm.seed(number)
        self._environment.reset_counts()
        learner._last_obs = None  # restart all episodes
        self._actor_learns = self._start is None or index >= hyperparameters.critic_warmup
        self._set_actor_learning(self._actor_learns)
        learner.learn(hyperparameters.part, callback=_RateCallback(self), reset_num_timesteps=False)
        self.adapt_rate()
        counts = self._environment
        row = {k: v / counts.decisions for k, v in counts.rewards.items()}
        control = self.tracking.rules.control_rate
        falls = 60.0 * control * counts.falls / counts.decisions
        standing, average = -1, -1.0
        if (
            self.goal
            and falls < 60.0 / MIN_TIME_BETWEEN_FALLS
            and (index + 1) % hyperparameters.evaluation_interval == 0
        ):
            policy = self.policy()
            self._evaluation = self._evaluation or ParallelTracking(
                policy.rules, hyperparameters.evaluation_starts
            )
            survived = survival_times(policy, self._evaluation, self.goal)
            standing = int((survived >= self.goal - 1e-6).sum())
            average = float(survived.mean())
            self.reached = standing == hyperparameters.evaluation_starts
        self.curve.append(
            LearningProgress(
                decisions=self.decisions + hyperparameters.part,
                seconds=before + clock.perf_counter() - start_time,
                falls_per_minute=falls,
                spread=float(learner.policy.log_std.detach().exp().mean()),
                rate=self._rate,
                standing=standing,
                lasted=average,
                **row,
            )
        )
        return self.curve[-1]

    def adapt_rate(self) -> None:
        """Adapt the learning rate to the divergence of the last update."""
        found = self._learner.logger.name_to_value.get("train/approx_kl")
        if found is None or not self._actor_learns:
            return
        target = self.hyperparameters.target_kl
        if found > 2.0 * target:
            self._rate = max(self._rate / RATE_FACTOR, MIN_RATE)
        elif found < 0.5 * target:
            self._rate = min(self._rate * RATE_FACTOR, MAX_RATE)
        self._learner.lr_schedule = _utils.ConstantSchedule(self._rate)

    def policy(self) -> Policy:
        """Return the present policy, without exploration noise."""
        layers = tuple(
            (m.weight.detach().cpu().numpy().T.copy(), m.bias.detach().cpu().numpy().copy())
            for m in self._actor()
        )
        rms = self._norm.obs_rms
        return Policy(
            layers=layers,
            mean=rms.mean.astype(np.float32),
            scale=np.sqrt(rms.var + self._norm.epsilon).astype(np.float32),
            rules=self.tracking.resolved_rules,
            about={
                "decisions": self.decisions,
                "seed": self.seed,
                "terrain_m": self.tracking.rules.terrain,
                "pushes_n": self.tracking.rules.pushes,
                "torch": _torch.__version__,
                "stable_baselines3": _sb3.__version__,
                **({} if self._start is None else {"start": self._start.digest}),
            },
        )

    def _start_from(self, policy: Policy, walks: SharedWalks) -> None:
        """Start from the actor and the normalisation of a policy.

        The policy acts first, because observations may vary more here, for instance with pushes.
        """
        human, rules = self.tracking.reference.human, self.tracking.resolved_rules
        layers, mean, scale = transfer_policy(policy, human, rules)
        same = Policy(layers=layers, mean=mean, scale=scale, rules=rules, about={})
        seen, rows = walks.reset(seed=self.seed)[0], []
        for _ in range(self.hyperparameters.steps):
            rows.append(seen)
            seen = walks.step(same(seen))[0]
        wider = np.maximum(scale, np.std(np.concatenate(rows), axis=0)).astype(scale.dtype)
        first, bias = layers[0]
        layers, scale = ((first * (wider / scale)[:, None], bias), *layers[1:]), wider
        with _torch.no_grad():
            for module, (weight, bias) in zip(self._actor(), layers, strict=True):
                module.weight.copy_(_torch.from_numpy(weight.T.copy()))
                module.bias.copy_(_torch.from_numpy(bias))
        rms = self._norm.obs_rms
        rms.mean, rms.var = mean.astype(float), scale.astype(float) ** 2
        rms.count = float(self.hyperparameters.part)

    def _actor(self) -> list[Any]:
        """Return the layers of the actor."""
        net = self._learner.policy
        linear = [m for m in net.mlp_extractor.policy_net if isinstance(m, _torch.nn.Linear)]
        return [*linear, net.action_net]

    def _set_actor_learning(self, whether: bool) -> None:
        own = [p for module in self._actor() for p in module.parameters()]
        for parameter in (*own, self._learner.policy.log_std):
            parameter.requires_grad_(whether)

    def _save(self) -> None:
        """Write checkpoint, curve and policy."""
        rms, learner = self._norm.obs_rms, self._learner
        state = {
            "what": self._identity(),
            "policy": learner.policy.state_dict(),
            "optimizer": learner.policy.optimizer.state_dict(),
            "mean": _torch.from_numpy(np.array(rms.mean)),
            "var": _torch.from_numpy(np.array(rms.var)),
            "count": float(rms.count),
            "rate": self._rate,
            "reached": self.goal if self.reached else None,
            "curve": [asdict(row) for row in self.curve],
        }
        path = self.folder / CHECKPOINT
        self.policy().save(self.folder / POLICY)
        with whole_file(path) as part:
            _torch.save(state, part)
        write_curve(self.folder / CURVE, self.curve)

    def _identity(self) -> dict[str, Any]:
        """Return all settings that affect the training, except its end."""
        rules = self.tracking.resolved_rules
        names = (
            "form",
            "gains",
            "reach",
            "rate",
            "control_rate",
            "passive",
            "duration",
            "mirrored",
            "terrain",
            "pushes",
        )
        reference = self.tracking.reference
        return {
            "seed": self.seed,
            **{name: getattr(rules, name) for name in names},
            "ground": str(rules.ground),
            "weights": asdict(self.tracking.weights),
            "base": asdict(self.tracking.action.gains),
            "human": reference.human.to_dict(),
            "period": reference.period,
            "reference": reference.digest,
            "start": None if self._start is None else self._start.digest,
            **{f"learning.{k}": v for k, v in asdict(self.hyperparameters).items()},
        }

    def _resume(self, path: Path) -> None:
        try:
            state = _torch.load(path, weights_only=True)
            what, curve = dict(state["what"]), [LearningProgress(**row) for row in state["curve"]]
        except Exception as error:
            raise FileError(path, f"not a checkpoint of a training: {str(error)[:200]}") from error
        own = self._identity()
        other = [k for k in own if what.get(k) != own[k]]
        if other:
            raise ParameterError(
                f"{path} is a checkpoint of another training: {', '.join(other)} differ; give "
                "another folder, or the options of that training"
            )
        learner, rms = self._learner, self._norm.obs_rms
        try:
            learner.policy.load_state_dict(state["policy"])
            learner.policy.optimizer.load_state_dict(state["optimizer"])
            seen = [state[name].numpy() for name in ("mean", "var")]
            numbers = [*np.concatenate(seen), float(state["count"]), float(state["rate"])]
            kept = [bool(_torch.isfinite(p).all()) for p in learner.policy.parameters()]
            if not (all(kept) and np.isfinite(numbers).all() and seen[0].shape == rms.mean.shape):
                raise ValueError("numbers are missing, or not finite")
            reached = state["reached"] is not None and state["reached"] >= self.goal > 0
        except Exception as error:
            raise FileError(path, f"damaged checkpoint: {str(error)[:200]}") from error
        (rms.mean, rms.var), (rms.count, self._rate) = seen, numbers[-2:]
        learner.lr_schedule = _utils.ConstantSchedule(self._rate)
        self.curve, self.reached = curve, reached


class _Learner(_sb3.PPO):
    """PPO with a constant learning rate of the critic."""

    def __init__(self, *args: Any, critic_rate: float, **options: Any):
        super().__init__(*args, **options)
        self._critic_rate, net = critic_rate, self.policy
        critic = [*net.mlp_extractor.value_net.parameters(), *net.value_net.parameters()]
        own = {id(p) for p in critic}
        actor = [p for p in net.parameters() if id(p) not in own]
        groups = [{"params": actor}, {"params": critic}]
        net.optimizer = _torch.optim.Adam(groups, lr=critic_rate, eps=1e-5)

    def _update_learning_rate(self, optimizers: Any) -> None:
        super()._update_learning_rate(optimizers)
        self.policy.optimizer.param_groups[1]["lr"] = self._critic_rate


def _learner(norm: Any, how: Hyperparameters, reach: Any, device: str) -> "_Learner":
    """Return the learner of a network of these hyperparameters.

    Args:
        reach: Reach of each action.
        device: torch device.
    """
    layers = {"pi": list(how.layers), "vf": list(how.layers)}
    return _Learner(
        "MlpPolicy",
        norm,
        learning_rate=how.rate,
        critic_rate=how.critic_rate,
        n_steps=how.steps,
        batch_size=how.batch,
        n_epochs=how.epochs,
        gamma=how.gamma,
        gae_lambda=how.gae_lambda,
        clip_range=how.clip,
        max_grad_norm=1.0,
        policy_kwargs={
            "net_arch": layers,
            "activation_fn": Elu,
            "log_std_init": float(np.log(how.action_std / reach)),
        },
        device=device,
    )


class _RateCallback(_sb3.common.callbacks.BaseCallback):
    """Adapts the learning rate after every update of a part except the last."""

    def __init__(self, training: Training):
        super().__init__()
        self._training = training

    def _on_step(self) -> bool:
        return True

    def _on_training_start(self) -> None:
        self._first = True

    def _on_rollout_start(self) -> None:
        if not self._first:
            self._training.adapt_rate()
        self._first = False
