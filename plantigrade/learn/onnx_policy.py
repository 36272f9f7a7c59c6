"""Policies as ONNX files: ours for other programs, and those of other learners here.

A file that :func:`write_onnx` wrote has the input ``observation`` (n, size) and the output
``action`` (n, size), both float32, with the normalisation of observations inside the network. Its
metadata hold the person, the rules and the reference, so it walks by itself. A file of another
learner needs only one input and one output of the sizes of ``plantigrade/Walk-v0``.
"""

import base64
import binascii
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.arrays import Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.extras import require
from plantigrade.io.writing import write_bytes
from plantigrade.learn.policy import OBSERVATION_CLIP, Policy, described_rules, file_of
from plantigrade.learn.rules import Rules
from plantigrade.options import LEARNED

SUFFIX, EXTRA = ".onnx", "onnx"
OPSET, IR_VERSION = 17, 9
"""Versions of operators and format, which every runtime since 2023 reads."""
DESCRIPTION, REFERENCE = "plantigrade.policy", "plantigrade.reference"
"""Metadata: a policy's description, and the frames of its reference, float32 in base 64."""
REMEDY = "name a policy in ONNX: plantigrade convert policy.npz policy.onnx writes one"


def is_onnx(path: str | Path) -> bool:
    """Return whether a file is in ONNX by its name."""
    return Path(path).suffix.lower() == SUFFIX


def write_onnx(policy: Policy, path: str | Path) -> Path:
    """Write a policy as an ONNX file; an existing file is replaced atomically.

    Raises:
        FileError: If the file cannot be written.
        MissingExtra: If the extra ``onnx`` is not installed.
    """
    onnx: Any = require("onnx", EXTRA)
    helper, array = onnx.helper, onnx.numpy_helper.from_array
    constants = {
        "mean": policy.mean,
        "scale": policy.scale,
        "lowest": np.float32(-OBSERVATION_CLIP),
        "highest": np.float32(OBSERVATION_CLIP),
        "least": np.float32(-1.0),
        "most": np.float32(1.0),
    }
    nodes = [
        helper.make_node("Sub", ["observation", "mean"], ["centred"]),
        helper.make_node("Div", ["centred", "scale"], ["scaled"]),
        helper.make_node("Clip", ["scaled", "lowest", "highest"], ["x0"]),
    ]
    for i, (weight, bias) in enumerate(policy.layers):
        constants |= {f"weight_{i}": weight, f"bias_{i}": bias}
        nodes.append(helper.make_node("MatMul", [f"x{i}", f"weight_{i}"], [f"product_{i}"]))
        nodes.append(helper.make_node("Add", [f"product_{i}", f"bias_{i}"], [f"sum_{i}"]))
        last = i == len(policy.layers) - 1
        activation = (["Clip", [f"sum_{i}", "least", "most"], ["action"]] if last
                      else ["Elu", [f"sum_{i}"], [f"x{i + 1}"]])  # fmt: skip
        nodes.append(helper.make_node(*activation))
    kind = onnx.TensorProto.FLOAT
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("observation", kind, ["n", len(policy.mean)])],
        [helper.make_tensor_value_info("action", kind, ["n", len(policy.layers[-1][1])])],
        [array(np.asarray(value, np.float32), name) for name, value in constants.items()],
    )
    opsets = [helper.make_opsetid("", OPSET)]
    model = helper.make_model(
        graph, producer_name="plantigrade", opset_imports=opsets, ir_version=IR_VERSION
    )
    table = policy.reference.table.astype("<f4")
    helper.set_model_props(
        model,
        {
            DESCRIPTION: policy.description,
            REFERENCE: base64.b64encode(table.tobytes()).decode("ascii"),
        },
    )
    onnx.checker.check_model(model)
    write_bytes(path, model.SerializeToString())
    return Path(path)


class OnnxPolicy:
    """The network of an ONNX file: a function from observations to actions within ±1.

    Attributes:
        path: The file.
        rules: Rules of its training with the reference; those of ``plantigrade/Walk-v0`` by
            default if the file has none.

    Raises:
        FileError: If the file does not exist, or is not a network with one input and one output.
        MissingExtra: If the extra ``onnx`` is not installed.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        if not self.path.is_file():
            raise FileError(self.path, "there is no such file", remedy=REMEDY)
        runtime: Any = require("onnxruntime", EXTRA)
        options = runtime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4
        try:
            self._session = runtime.InferenceSession(
                self.path.read_bytes(), options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # the runtime has no error family of its own
            raise self._refused(f"cannot be read: {str(error)[:200]}") from error
        inputs, outputs = self._session.get_inputs(), self._session.get_outputs()
        if len(inputs) != 1 or not outputs or len(inputs[0].shape) != 2:
            names = ", ".join(f"{x.name} {x.shape}" for x in inputs)
            raise self._refused(f"must have one input of shape (n, size), and has {names}")
        self._input = inputs[0]
        self._output = outputs[0]
        about = self._session.get_modelmeta().custom_metadata_map
        self.rules = Rules()
        if DESCRIPTION in about:
            self.rules = described_rules(
                self.path, about[DESCRIPTION], lambda n: self._frames(about.get(REFERENCE, ""), n)
            )[0]

    def require_sizes(self, observation: int, action: int) -> None:
        """Check the sizes of observations and actions against those of the rules.

        Raises:
            FileError: If they differ.
        """
        own = self._input.shape[1]
        if isinstance(own, int) and own != observation:
            raise self._refused(f"takes {own} numbers; an observation has {observation}")
        found = self(np.zeros((1, observation))).shape[1]
        if found != action:
            raise self._refused(f"returns {found} numbers; an action has {action}")

    def __call__(self, seen: Float[np.ndarray, "n size"]) -> Float[np.ndarray, "n k"]:
        """Return actions within ±1, one row per observation.

        Raises:
            FileError: If the network does not compute numbers from observations.
        """
        kind = np.float64 if "double" in self._input.type else np.float32
        rows = np.asarray(seen, kind)
        one = self._input.shape[0] == 1  # exported for one person
        parts = rows[:, None] if one else rows[None]
        try:
            found = [self._session.run([self._output.name], {self._input.name: x})[0]
                     for x in parts]  # fmt: skip
            actions = np.concatenate([np.asarray(x, float).reshape(len(p), -1)
                                      for x, p in zip(found, parts, strict=True)])  # fmt: skip
        except Exception as error:  # the runtime has no error family of its own
            raise self._refused(f"fails on an observation: {str(error)[:200]}") from error
        return np.clip(actions, -1.0, 1.0)

    def _frames(self, text: str, columns: int) -> np.ndarray:
        """Return the frames of the reference; raise a ValueError if they are none."""
        try:
            numbers = np.frombuffer(base64.b64decode(text, validate=True), "<f4")
        except binascii.Error as error:
            raise ValueError(f"{REFERENCE}: {error}") from error
        if not np.isfinite(numbers).all():
            raise ValueError(f"{REFERENCE}: not all numbers are finite")
        return numbers.reshape(-1, columns)

    def _refused(self, problem: str) -> FileError:
        return FileError(self.path, problem, remedy=REMEDY)


def convert_policy(source: Path, target: Path, **options: Any) -> list[str]:
    """Write a ``policy.npz``, or the bundled one named ``learned``, in ONNX; return no notes.

    Raises:
        ParameterError: If options are given, because a policy has none.
        FileError: If the source is not a policy, or the target cannot be written.
        MissingExtra: If the extra ``onnx`` is not installed.
    """
    if options:
        raise ParameterError(f"a policy takes no options: leave out {', '.join(options)}")
    policy = Policy.load(file_of(LEARNED) if str(source) == LEARNED else source)
    write_onnx(policy, target)
    return []
