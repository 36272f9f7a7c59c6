"""Proximal policy optimisation of a walk, by stable-baselines3.

Training goes in parts of a few updates. Every part starts all episodes anew, from random numbers of
its own, and all that it leaves is in the checkpoint: so one that was stopped and taken up again
ends in the same policy, number for number, as one that was not.
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
from plantigrade.learn.curve import Progress, write_curve
from plantigrade.learn.environment import Walks
from plantigrade.learn.following import Following, Rules
from plantigrade.learn.hyperparameters import GOING_ON, Learning
from plantigrade.learn.persons import Persons
from plantigrade.learn.policy import CLIP, Policy, lasted
from plantigrade.learn.transfer import carried_over

_torch = require("torch", "learn")
_sb3 = require("stable_baselines3", "learn")
_vec = require("stable_baselines3.common.vec_env", "learn")
_utils = require("stable_baselines3.common.utils", "learn")

CHECKPOINT, POLICY, CURVE = "checkpoint.pt", "policy.npz", "curve.csv"
"""Names of the files of a training."""
CHANGE = 1.5
"""Factor by which the learning rate follows the divergence."""
SLOWEST, FASTEST = 1e-5, 1e-3
"""Range of learning rates."""
READY = 4.0
"""With fewer falls than one in so long a time the goal is looked at [s]."""


class Training:
    """A policy that learns, in a folder.

    Args:
        rules: What an episode is.
        folder: Where checkpoint, curve and policy are; it must exist. A checkpoint that is there is
            taken up.
        seed: Of all random numbers.
        goal: Training ends where none of the starts leads to a fall in so long a time; zero: never
            [s].
        most: Training ends after so many decisions.
        how: How it learns; if absent, as who begins with nothing, or :data:`GOING_ON`.
        device: Of torch.
        start: A policy to begin with, of any feet.

    Raises:
        ParameterError: If the checkpoint there is of another training.
        FileError: If it cannot be read.
        MissingExtra: If the extra is not installed.

    Attributes:
        curve: What has been so far.
        reached: Whether the goal was.
    """

    def __init__(
        self,
        rules: Rules,
        folder: str | Path,
        *,
        seed: int = 0,
        goal: float = 20.0,
        most: int = 3_000_000,
        how: Learning | None = None,
        device: str = "cpu",
        start: Policy | None = None,
    ):
        how = how or (Learning() if start is None else GOING_ON)
        self.folder, self.seed, self.goal, self.most = Path(folder), seed, goal, most
        self.how, self.curve, self.reached = how, list[Progress](), False
        try:
            _torch.empty(0, device=device)
        except Exception as error:  # of many kinds
            raise ParameterError(f"device={device!r}: {str(error)[:160]}") from error
        _torch.set_num_threads(1)
        walks = Walks(how.persons, **{f.name: getattr(rules, f.name) for f in fields(rules)})
        self.following = walks.following
        self._persons = Persons(walks, 5.0 * (1.0 - how.gamma))
        self._norm = _vec.VecNormalize(self._persons, norm_reward=False, clip_obs=CLIP)
        _utils.set_random_seed(seed)
        self._learner = _Learner(
            "MlpPolicy",
            self._norm,
            learning_rate=how.rate,
            n_steps=how.steps,
            batch_size=how.batch,
            n_epochs=how.epochs,
            gamma=how.gamma,
            gae_lambda=how.trace,
            clip_range=how.clip,
            max_grad_norm=1.0,
            policy_kwargs={
                "net_arch": {"pi": list(how.layers), "vf": list(how.layers)},
                "activation_fn": _torch.nn.ELU,
                "log_std_init": float(np.log(how.spread / self.following.action.reach)),
            },
            device=device,
        )
        if how.judging is not None:
            self._learner.part(how.judging)
        self._learner.set_logger(_sb3.common.logger.Logger(None, []))
        self._rate, self._acting = how.rate, True
        self._judged: Following | None = None
        self._start = start
        # What is seen is normalised as it was, so that what was learned stays true.
        self._norm.training = start is None
        if (self.folder / CHECKPOINT).exists():
            self._take_up(self.folder / CHECKPOINT)
        elif start is not None:
            self._begin_with(start, walks)

    @property
    def decisions(self) -> int:
        """How many there have been."""
        return self.curve[-1].decisions if self.curve else 0

    @property
    def network(self) -> Any:
        """Actor and critic, as torch has them."""
        return self._learner.policy

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self.reached or self.decisions >= self.most

    def run(self, tell: Callable[[Progress], None] = lambda _: None) -> Policy:
        """Learn until the goal or the end, and return the policy, which is in the folder, too.

        Args:
            tell: Is called after every part.
        """
        while not self.over:
            row = self.learn()
            self._keep()
            tell(row)
        return self.policy()

    def learn(self) -> Progress:
        """Do one part, and return how it went."""
        began, how, learner = clock.perf_counter(), self.how, self._learner
        index, before = len(self.curve), self.curve[-1].seconds if self.curve else 0.0
        number = int(np.random.SeedSequence([self.seed, index]).generate_state(1)[0]) % 2**31
        _utils.set_random_seed(number)
        self._norm.seed(number)
        self._persons.count_anew()
        learner._last_obs = None  # so that all episodes start anew
        self._acting = self._start is None or index >= how.listening
        self._let_actor_learn(self._acting)
        learner.learn(how.part, callback=_Follow(self), reset_num_timesteps=False)
        self.follow()
        counted = self._persons
        row = {k: v / counted.decisions for k, v in counted.rewards.items()}
        control = self.following.rules.control_rate
        falls = 60.0 * control * counted.falls / counted.decisions
        standing, average = -1, -1.0
        if self.goal and falls < 60.0 / READY and (index + 1) % how.patience == 0:
            policy = self.policy()
            self._judged = self._judged or Following(policy.rules, how.starts)
            survived = lasted(policy, self._judged, self.goal)
            standing = int((survived >= self.goal - 1e-6).sum())
            average = float(survived.mean())
            self.reached = standing == how.starts
        self.curve.append(
            Progress(
                decisions=self.decisions + how.part,
                seconds=before + clock.perf_counter() - began,
                falls_per_minute=falls,
                spread=float(learner.policy.log_std.detach().exp().mean()),
                rate=self._rate,
                standing=standing,
                lasted=average,
                **row,
            )
        )
        return self.curve[-1]

    def follow(self) -> None:
        """Let the learning rate follow the divergence of the last update."""
        found = self._learner.logger.name_to_value.get("train/approx_kl")
        if found is None or not self._acting:
            return
        wanted = self.how.divergence
        if found > 2.0 * wanted:
            self._rate = max(self._rate / CHANGE, SLOWEST)
        elif found < 0.5 * wanted:
            self._rate = min(self._rate * CHANGE, FASTEST)
        self._learner.lr_schedule = _utils.ConstantSchedule(self._rate)

    def policy(self) -> Policy:
        """Return the policy as it is now, without its noise."""
        layers = tuple(
            (
                m.weight.detach().cpu().numpy().T.copy(),
                m.bias.detach().cpu().numpy().copy(),
            )
            for m in self._actor()
        )
        rms = self._norm.obs_rms
        return Policy(
            layers=layers,
            mean=rms.mean.astype(np.float32),
            scale=np.sqrt(rms.var + self._norm.epsilon).astype(np.float32),
            rules=self.following.settled,
            about={
                "decisions": self.decisions,
                "seed": self.seed,
                "terrain_m": self.following.rules.terrain,
                "pushes_n": self.following.rules.pushes,
                "torch": _torch.__version__,
                "stable_baselines3": _sb3.__version__,
                **({} if self._start is None else {"start": self._start.digest}),
            },
        )

    def _begin_with(self, policy: Policy, walks: Walks) -> None:
        """Take over the actor of a policy, and its normalisation.

        What is seen may spread wider here, as where there are pushes: so far it is let act first.
        """
        human, rules = self.following.reference.human, self.following.settled
        layers, mean, scale = carried_over(policy, human, rules)
        same = Policy(layers=layers, mean=mean, scale=scale, rules=rules, about={})
        seen, rows = walks.reset(seed=self.seed)[0], []
        for _ in range(self.how.steps):
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
        rms.count = float(self.how.part)

    def _actor(self) -> list[Any]:
        """Return the layers of the actor."""
        net = self._learner.policy
        linear = [m for m in net.mlp_extractor.policy_net if isinstance(m, _torch.nn.Linear)]
        return [*linear, net.action_net]

    def _let_actor_learn(self, whether: bool) -> None:
        own = [p for module in self._actor() for p in module.parameters()]
        for parameter in (*own, self._learner.policy.log_std):
            parameter.requires_grad_(whether)

    def _keep(self) -> None:
        """Write checkpoint, curve and policy."""
        rms, learner = self._norm.obs_rms, self._learner
        state = {
            "what": self._what(),
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

    def _what(self) -> dict[str, Any]:
        """Return what decides the training, but its end."""
        rules = self.following.settled
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
        reference = self.following.reference
        return {
            "seed": self.seed,
            **{name: getattr(rules, name) for name in names},
            "ground": str(rules.ground),
            "weights": asdict(self.following.weights),
            "human": reference.human.to_dict(),
            "period": reference.period,
            "start": None if self._start is None else self._start.digest,
            **{f"learning.{k}": v for k, v in asdict(self.how).items()},
        }

    def _take_up(self, path: Path) -> None:
        try:
            state = _torch.load(path, weights_only=True)
            what, curve = dict(state["what"]), [Progress(**row) for row in state["curve"]]
        except Exception as error:
            raise FileError(path, f"not a checkpoint of a training: {str(error)[:200]}") from error
        mine = self._what()
        other = [k for k in mine if what.get(k) != mine[k]]
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
    """The learner, whose critic may have a learning rate of its own."""

    _judging: float | None = None

    def part(self, judging: float) -> None:
        """Let the critic learn at a rate that stays."""
        self._judging, net = judging, self.policy
        critic = [*net.mlp_extractor.value_net.parameters(), *net.value_net.parameters()]
        own = {id(p) for p in critic}
        actor = [p for p in net.parameters() if id(p) not in own]
        groups = [{"params": actor}, {"params": critic}]
        net.optimizer = _torch.optim.Adam(groups, lr=judging, eps=1e-5)

    def _update_learning_rate(self, optimizers: Any) -> None:
        super()._update_learning_rate(optimizers)
        if self._judging is not None:
            self.policy.optimizer.param_groups[1]["lr"] = self._judging


class _Follow(_sb3.common.callbacks.BaseCallback):
    """Lets the learning rate follow after every update of a part but the last."""

    def __init__(self, training: Training):
        super().__init__()
        self._training = training

    def _on_step(self) -> bool:
        return True

    def _on_training_start(self) -> None:
        self._first = True

    def _on_rollout_start(self) -> None:
        if not self._first:
            self._training.follow()
        self._first = False
