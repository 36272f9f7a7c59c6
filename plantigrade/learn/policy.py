"""A trained policy, stored as one small file and evaluated with NumPy alone.

The file is an npz without pickles. It has the layers of the network (``weight_0``, ``bias_0``, …),
the normalisation of observations (``mean``, ``scale``), one stride of the reference
(``reference``), and ``about``, JSON with the person, the rules, the versions and details of the
training.
"""

import hashlib
import io
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.arrays import Float
from plantigrade.bounds import number
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.npz import Arrays
from plantigrade.io.writing import write_bytes
from plantigrade.learn.action import Gains
from plantigrade.learn.parallel_tracking import ParallelTracking
from plantigrade.learn.policy_interface import PolicyInterface
from plantigrade.learn.reference import EXTRA_COLUMNS, ReferenceMotion
from plantigrade.learn.rules import Rules
from plantigrade.models import Human
from plantigrade.options import LEARNED

OBSERVATION_CLIP = 8.0  # [standard deviations] of normalised observations
QUATERNION_TOLERANCE = 0.01  # of the norm of a quaternion
REMEDY = "name a policy.npz that plantigrade train wrote"
KIND = "plantigrade policy 1"  # Kind and version of the file format
FOLDER = Path(__file__).resolve().parent / "policies"
"""Where the policies of the package are, one for each foot."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Policy:
    """A network and all that is needed to evaluate it.

    Attributes:
        layers: Weights (inputs, outputs) and biases (outputs,) of each layer; ELU between them.
        mean: Mean of observations, for their normalisation.
        scale: Standard deviation of observations.
        rules: Rules of the training, with its reference.
        about: Details of the training, such as versions, seed and decisions.
    """

    layers: tuple[tuple[np.ndarray, np.ndarray], ...]
    mean: Float[np.ndarray, " size"]
    scale: Float[np.ndarray, " size"]
    rules: Rules
    about: Mapping[str, Any]

    @property
    def reference(self) -> ReferenceMotion:
        """Reference walk."""
        assert isinstance(self.rules.reference, ReferenceMotion)
        return self.rules.reference

    @property
    def digest(self) -> str:
        """Hash of the network."""
        found = hashlib.sha256()
        for weight, bias in self.layers:
            found.update(weight.tobytes() + bias.tobytes())
        return found.hexdigest()[:12]

    @property
    def description(self) -> str:
        """All but the network and the motion of the reference, as JSON."""
        rules, reference = self.rules, self.reference
        about = {
            "kind": KIND,
            "human": reference.human.to_dict(),
            "period": reference.period,
            "stride": reference.stride,
            "cyclic": reference.cyclic,
            "rules": {name: getattr(rules, name) for name in _PLAIN},
            "base": asdict(rules.base or Gains()),
            "about": dict(self.about),
        }
        return json.dumps(about, sort_keys=True)

    def __call__(self, seen: Float[np.ndarray, "n size"]) -> Float[np.ndarray, "n k"]:
        """Return actions within ±1, one row per observation."""
        x = np.clip((seen - self.mean) / self.scale, -OBSERVATION_CLIP, OBSERVATION_CLIP)
        for weight, bias in self.layers[:-1]:
            x = x @ weight
            x += bias
            x = np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0)))
        weight, bias = self.layers[-1]
        return np.clip(x @ weight + bias, -1.0, 1.0)

    def save(self, path: str | Path) -> Path:
        """Write the policy; an existing file is replaced atomically.

        Raises:
            FileError: If the file cannot be written.
        """
        path, reference = Path(path), self.reference
        arrays: dict[str, Any] = {"mean": self.mean, "scale": self.scale}
        for i, (weight, bias) in enumerate(self.layers):
            arrays |= {f"weight_{i}": weight, f"bias_{i}": bias}
        arrays["reference"] = reference.table.astype(np.float32)
        arrays["about"] = np.array(self.description)
        stream = io.BytesIO()
        np.savez_compressed(stream, **arrays)
        write_bytes(path, stream.getvalue())
        return path

    @classmethod
    def load(cls, path: str | Path) -> "Policy":
        """Read a policy.

        Raises:
            FileError: If the file does not exist or is not a complete policy.
        """
        arrays = Arrays(path, REMEDY)
        rules, reference, trained = described_rules(
            path,
            str(arrays.any("about")),
            lambda columns: _numbers(arrays, "reference", None, columns),
        )
        form = PolicyInterface(reference.human, rules)
        size, layers = len(form.observation), []
        mean, scale = (_numbers(arrays, name, size) for name in ("mean", "scale"))
        if scale.min() <= 0.0:
            arrays.refuse("holds a standard deviation that is not positive", "scale")
        while f"weight_{len(layers)}" in arrays:
            weight = _numbers(arrays, f"weight_{len(layers)}", size, None)
            size = weight.shape[1]
            layers.append((weight, _numbers(arrays, f"bias_{len(layers)}", size)))
        if size != len(form.action):
            arrays.refuse(
                f"ends in {size} numbers, not {len(form.action)}", f"weight_{len(layers)}"
            )
        return cls(layers=tuple(layers), mean=mean, scale=scale, rules=rules, about=trained)


def described_rules(
    path: str | Path, description: str, table: Callable[[int], np.ndarray]
) -> tuple[Rules, ReferenceMotion, dict[str, Any]]:
    """Return the rules of a policy, their reference, and the details of its training.

    Args:
        path: File that they are from.
        description: A policy's :attr:`~Policy.description`.
        table: Function from the number of columns to the frames of the reference.

    Raises:
        FileError: If they are not those of a policy.
    """
    try:
        about = json.loads(description)
        if about["kind"] != KIND:
            raise ValueError(f"it is {about['kind']!r}, not {KIND!r}")
        _described(about)
        human = Human.from_dict(about["human"])
        frames = np.asarray(table(human.model.nq + human.model.nv + EXTRA_COLUMNS), dtype=float)
        walk = (float(about["period"]), float(about["stride"]), bool(about["cyclic"]))
        reference = ReferenceMotion(human, *walk, frames)
        rules = Rules(reference=reference, base=Gains(**about["base"]), **about["rules"])
        trained = dict(about["about"])
    except (KeyError, TypeError, ValueError, RecursionError, ParameterError) as error:
        why = f"is not a policy of this version: {str(error)[:200]}"
        raise FileError(path, why, remedy=REMEDY) from error
    norms = np.linalg.norm(frames[:, 3:7], axis=1)
    if len(frames) < 2 or np.abs(norms - 1.0).max() > QUATERNION_TOLERANCE:
        problem = "is not a motion: it is too short, or rotations of the pelvis are invalid"
        raise FileError(path, problem, where="reference", remedy=REMEDY)
    return rules, reference, trained


def survival_times(
    policy: Policy, tracking: ParallelTracking, duration: float
) -> Float[np.ndarray, " n"]:
    """Return the walking times until a fall, from initial phases spread over the stride [s].

    Args:
        duration: Maximum duration [s].
    """
    n, rate = len(tracking.worlds), tracking.rules.control_rate
    tracking.start_episodes(range(n), [(i + 0.5) / n for i in range(n)], range(n))
    steps = round(duration * rate)
    times, up = np.full(n, steps / rate), np.ones(n, dtype=bool)
    for k in range(steps):
        _, ends, _, _ = tracking.step(policy(tracking.observations()))
        fell = up & np.array([bool(end) for end in ends])
        times[fell] = k / rate
        up &= ~fell
        if not up.any():
            break
    return times


def _described(about: Mapping[str, Any]) -> None:
    """Check the description of a file.

    Raises:
        KeyError: If an entry is missing or unknown.
        ParameterError: If a number is out of bounds.
    """
    rules, base = about["rules"], about["base"]
    for part, known in ((rules, _PLAIN), (base, [f.name for f in fields(Gains)])):
        for name in set(part).symmetric_difference(known):
            raise KeyError(f"{name[:40]!r} is {'unknown' if name in part else 'missing'}")
    for name, value in {**about, **rules, **base}.items():
        if name in _FLAGS:
            if not (isinstance(value, bool) or (value is None and name == "gains")):
                raise TypeError(f"{name} must be true or false")
        elif name in _BOUNDS and not (value is None and name == "reach"):
            number(name, value, *_BOUNDS[name])


def _numbers(arrays: Arrays, key: str, *shape: int | None) -> np.ndarray:
    """Return an array; raise a FileError if it is missing or not finite."""
    numbers = arrays.finite(key, *shape)
    if numbers is None:
        arrays.refuse("is missing", key)
    return np.asarray(numbers, dtype=np.float32)


_FLAGS = ("cyclic", "gains", "passive", "mirrored", "ankle_too")
_GAIN = (0.0, 1e5, "N m by rad and s")  # range of gains in a policy file; chosen
_BOUNDS: Mapping[str, tuple[float, float, str]] = {
    "period": (0.05, 1000.0, "s"),
    "stride": (-100.0, 100.0, "m"),
    "rate": (1.0, 1e5, "1/s"),
    "control_rate": (1.0, 1e5, "1/s"),
    "duration": (0.01, 3600.0, "s"),
    "reach": (1e-3, 100.0, "rad"),
    "stiffness": _GAIN,
    "damping": _GAIN,
    "foot_stiffness": _GAIN,
    "foot_damping": _GAIN,
    "span": (1.0, 1e5, "times"),
    "damping_span": (1.0, 1e5, "times"),
}
"""Bounds and units of the numbers in a file."""
_PLAIN = ("form", "gains", "reach", "rate", "control_rate", "passive", "duration", "mirrored")
"""Fields of the rules in a file."""


def shipped(feet: str) -> Path:
    """Return the file of the policy of the package that walks on such feet."""
    path = FOLDER / f"{feet}.npz"
    if not path.is_file():
        there = sorted(file.stem for file in FOLDER.glob("*.npz"))
        raise ParameterError(
            f"controller={LEARNED} walks on feet={' or '.join(there)}, not {feet}; train a policy "
            "of your own: plantigrade train --help"
        )
    return path


def file_of(word: str, feet: str | None = None) -> Path:
    """Return the file of a policy by its word: ``learned``, for that of the package, or itself.

    Raises:
        ParameterError: If the package has none for such feet (multi-segment if absent).
    """
    return shipped(feet or "multi-segment") if word == LEARNED else Path(word)
