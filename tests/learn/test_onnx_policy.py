"""Policies in ONNX: ours for others, and those of others here."""

import numpy as np
import pytest

from plantigrade.commands.main import main
from plantigrade.errors import FileError, PlantigradeError
from plantigrade.learn import OnnxPolicy, Policy, PolicyController, write_onnx
from plantigrade.learn.policy import shipped
from plantigrade.workflows.simulate import simulate

onnx = pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")
pytestmark = pytest.mark.slow  # with the extra onnx


@pytest.fixture(scope="module")
def policy():
    return Policy.load(shipped("multi-segment"))


@pytest.fixture(scope="module")
def file(policy, tmp_path_factory):
    return write_onnx(policy, tmp_path_factory.mktemp("onnx") / "policy.onnx")


def network(path, inputs, outputs, *, rows="n", kind="FLOAT"):
    """A network of another learner: actions from a sum of all observations."""
    make, number = onnx.helper, getattr(onnx.TensorProto, kind)
    weight = onnx.numpy_helper.from_array(
        np.full((inputs, outputs), 1e-3, np.float64 if kind == "DOUBLE" else np.float32), "w"
    )
    graph = make.make_graph(
        [make.make_node("MatMul", ["obs", "w"], ["mean"])], "actor",
        [make.make_tensor_value_info("obs", number, [rows, inputs])],
        [make.make_tensor_value_info("mean", number, [rows, outputs])], [weight],
    )  # fmt: skip
    model = make.make_model(graph, opset_imports=[make.make_opsetid("", 17)], ir_version=9)
    onnx.save(model, path)
    return path


def test_a_network_decides_alike_in_both_formats(policy, file):
    again = OnnxPolicy(file)
    seen = 3.0 * np.random.default_rng(0).normal(size=(5, len(policy.mean)))
    np.testing.assert_allclose(again(seen), policy(seen.astype(np.float32)), atol=1e-5)
    assert again.rules.mirrored == policy.rules.mirrored and again.rules.base == policy.rules.base
    assert again.rules.reference.human.to_dict() == policy.reference.human.to_dict()
    time = np.array([0.1, 0.7])
    np.testing.assert_array_equal(
        again.rules.reference.at(time).qpos, policy.reference.at(time).qpos
    )


def test_a_policy_in_onnx_walks_as_that_it_was_made_of(file):
    ours = simulate(controller="learned", duration=3.0)
    theirs = simulate(controller=str(file), duration=3.0)
    np.testing.assert_allclose(
        theirs.record.motion.qpos[-1], ours.record.motion.qpos[-1], atol=0.02
    )


@pytest.mark.parametrize(("rows", "kind"), [("n", "FLOAT"), (1, "FLOAT"), ("n", "DOUBLE")])
def test_a_network_of_another_learner_controls_the_person_of_the_environment(tmp_path, rows, kind):
    policy = OnnxPolicy(network(tmp_path / "actor.onnx", 324, 36, rows=rows, kind=kind))
    seen = np.random.default_rng(0).normal(size=(3, 324))
    np.testing.assert_allclose(
        policy(seen), np.tile(1e-3 * seen.sum(axis=1, keepdims=True), 36), atol=1e-6
    )
    assert PolicyController(policy).reference.human.height == 1.5


@pytest.mark.parametrize(
    ("sizes", "word"), [((300, 36), "an observation has 324"), ((324, 30), "an action has 36")]
)
def test_a_network_of_other_sizes_is_refused(tmp_path, sizes, word):
    with pytest.raises(FileError, match=word):
        PolicyController(OnnxPolicy(network(tmp_path / "actor.onnx", *sizes)))


def test_what_is_no_network_is_refused(tmp_path, file):
    broken = tmp_path / "broken.onnx"
    broken.write_bytes(file.read_bytes()[:1000])
    for path in (broken, tmp_path / "none.onnx"):
        with pytest.raises(FileError, match=path.name):
            OnnxPolicy(path)
    model = onnx.load(file)
    for entry in model.metadata_props:
        if entry.key == "plantigrade.reference":
            entry.value = entry.value[:400]
    onnx.save(model, tmp_path / "short.onnx")
    with pytest.raises(PlantigradeError, match=r"short\.onnx"):
        OnnxPolicy(tmp_path / "short.onnx")


def test_a_bundled_policy_is_converted(tmp_path, file, capsys):
    assert main(["convert", "learned", str(tmp_path / "own.onnx")]) == 0
    assert (tmp_path / "own.onnx").read_bytes() == file.read_bytes()
    assert main(["convert", "learned", str(tmp_path / "x.onnx"), "--rate", "100"]) == 2
    assert not (tmp_path / "x.onnx").exists()
    (tmp_path / "no.npz").write_bytes(b"PK")
    assert main(["convert", str(tmp_path / "no.npz"), str(tmp_path / "x.onnx")]) == 2
    capsys.readouterr()
