"""Functions at many nodes: vectors against CasADi's interpreter, and what is kept on disk."""

import sys
from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from plantigrade.batched import BatchedFunction, llvm, tables, vector_machine
from plantigrade.contact.site import foot_sites
from plantigrade.dynamics.symbolic import SymbolicHuman
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from tests.models.presets import person

needs_llvm = pytest.mark.skipif(
    bool(BatchedFunction.unavailable()), reason=BatchedFunction.unavailable()
)

CACHE = "PLANTIGRADE_CACHE"

x, y = ca.SX.sym("x"), ca.SX.sym("y")
ONE_ARGUMENT = {
    "neg": -x,
    "sq": x**2,
    "twice": x + x,
    "inv": 1 / x,
    "sqrt": ca.sqrt(x * x + 1),
    "exp": ca.exp(x),
    "log": ca.log(x * x + 1),
    "sin": ca.sin(x),
    "cos": ca.cos(x),
    "tan": ca.tan(x),
    "asin": ca.asin(ca.sin(x)),
    "acos": ca.acos(ca.sin(x)),
    "atan": ca.atan(x),
    "sinh": ca.sinh(x),
    "cosh": ca.cosh(x),
    "tanh": ca.tanh(x),
    "asinh": ca.asinh(x),
    "acosh": ca.acosh(x * x + 1.5),
    "atanh": ca.atanh(ca.sin(x)),
    "expm1": ca.expm1(x),
    "log1p": ca.log1p(x * x),
    "erf": ca.erf(x),
    "floor": ca.floor(x),
    "ceil": ca.ceil(x),
    "fabs": ca.fabs(x),
    "sign": ca.sign(x),
    "not": ca.logic_not(x),
    "constpow": (x * x + 0.1) ** 1.7,
    "itself": x,
    "constant": x * 0 + 3.25,
}
TWO_ARGUMENTS = {
    "add": x + y,
    "sub": x - y,
    "mul": x * y,
    "div": x / y,
    "pow": (x * x + 0.1) ** y,
    "fmod": ca.fmod(x, y),
    "remainder": ca.remainder(x, y),
    "atan2": ca.atan2(x, y),
    "hypot": ca.hypot(x, y),
    "fmin": ca.fmin(x, y),
    "fmax": ca.fmax(x, y),
    "copysign": ca.copysign(x, y),
    "lt": x < y,
    "le": x <= y,
    "eq": x == y,
    "ne": x != y,
    "and": ca.logic_and(x, y),
    "or": ca.logic_or(x, y),
    "if_else_zero": ca.if_else(x > 0, y, 0),
    "if_else": ca.if_else(x > y, x, 2 * y),
}
EVERYTHING = ca.Function(
    "everything", [x, y], [ca.vertcat(*ONE_ARGUMENT.values(), *TWO_ARGUMENTS.values())]
)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Keep files in a folder of the test, and nothing in memory but the machine."""
    if not BatchedFunction.unavailable():
        for lanes in vector_machine.LANES:
            vector_machine._machine(lanes)
    monkeypatch.setenv(CACHE, str(tmp_path))
    return tmp_path / "functions"


@pytest.fixture
def plain_processor(monkeypatch):
    """Make the machine for a processor without wide vectors."""
    if "x86_64" not in llvm.target():
        pytest.skip("another processor")
    kept = (llvm.target, llvm.vector_width, vector_machine._machine)
    for each in kept:
        each.cache_clear()
    monkeypatch.setattr(llvm, "_host", lambda: ("x86-64", ""))
    yield
    for each in kept:
        each.cache_clear()


def states(function, n, seed=0):
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(n, function.size1_in(i))) for i in range(function.n_in())]


def both(function, inputs, **settings):
    """Return outputs by vectors and by the interpreter."""
    return tuple(
        BatchedFunction(function, backend=b, **settings)(*inputs)
        for b in ("vectors", "interpreter")
    )


def assert_same(function, inputs, **settings):
    for ours, theirs in zip(*both(function, inputs, **settings), strict=True):
        scale = np.abs(theirs).max(axis=0, initial=0)
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-13 * scale.max(initial=0))


def edges():
    """Return pairs of all numbers at which operations may differ."""
    some = np.array([-np.inf, -2.5, -1.0, -0.0, 0.0, 0.5, 1.0, 2.5, np.inf, np.nan])
    return [each.reshape(-1, 1) for each in np.meshgrid(some, some)]


@needs_llvm
def test_every_operation_is_that_of_the_interpreter():
    assert_same(EVERYTHING, states(EVERYTHING, 50))
    ours, theirs = both(EVERYTHING, edges())
    for k, name in enumerate([*ONE_ARGUMENT, *TWO_ARGUMENTS]):
        np.testing.assert_allclose(ours[0][:, k], theirs[0][:, k], rtol=1e-13, err_msg=name)


@needs_llvm
def test_every_operation_on_a_plain_processor(plain_processor):
    assert llvm.vector_width() == 4
    assert_same(EVERYTHING, states(EVERYTHING, 50))


@needs_llvm
@pytest.mark.parametrize("n", [1, 7, 8, 9, 16, 17, 32, 33, 64, 65, 200])
def test_any_number_of_nodes(n):
    v = ca.SX.sym("v", 3)
    f = ca.Function("f", [v, x], [ca.cross(v, v * x + 1), ca.diag(v), ca.SX(2, 2)])
    assert_same(f, states(f, n))
    rows, columns = BatchedFunction(f).pattern(1)
    assert rows.tolist() == columns.tolist() == [0, 1, 2]


@needs_llvm
def test_values_are_there_until_they_are_needed_last():
    v, chain = ca.SX.sym("v", 20), []
    for k in range(3000):  # uses values from far back, and from the last one
        a = chain[(7 * k) % len(chain)] if chain else v[0]
        b = chain[-1] if chain else 1
        chain.append([ca.sin(a) + v[k % 20] * b, ca.cos(a) * b - a, a - 0.1 * v[3] * b][k % 3])
    f = ca.Function("f", [v], [chain[-1], ca.vertcat(*chain[::100])])
    assert f.n_instructions() > 5000
    program = tables.Program.of(f)
    table = tables.tabulated(program, len(program.constants))
    assert table.lines[0] < len(program.operations) - 1500  # sums with products are one line
    assert table.n_places < len(program.operations) / 2
    assert_same(f, states(f, 21))


def test_no_nodes_give_no_rows():
    assert BatchedFunction(EVERYTHING)(np.zeros((0, 1)), np.zeros((0, 1)))[0].shape == (0, 50)


@needs_llvm
def test_other_parameters_use_the_same_table(folder):
    def f(c):
        return BatchedFunction.parametrised(ca.Function("f", [x], [c * ca.sin(x) + 2 * c]))

    (g, three, key), (_, seven, other) = f(0.3), f(0.7)
    assert key == other
    one = BatchedFunction(g, key=key, parameters=three)
    two = BatchedFunction(forbid, key=key, parameters=seven)
    assert len(list(folder.iterdir())) == 1
    at = np.linspace(-1, 1, 11)[:, None]
    np.testing.assert_allclose(one(at)[0], 0.3 * np.sin(at) + 0.6)
    np.testing.assert_allclose(two(at)[0], 0.7 * np.sin(at) + 1.4)


@needs_llvm
def test_a_body_is_the_same_by_vectors():
    body = SymbolicHuman(person("66", "multi-segment"))
    q, v, a = (ca.SX.sym(n, body.nv) for n in "qva")
    points = list(foot_sites(body.human))
    u = ca.SX.sym("u", 3 * len(points))
    f = ca.Function(
        "f", [q, v, a, u], [body.inverse_dynamics(points)(q, v, a, ca.reshape(u, 3, -1))]
    )
    assert_same(f, states(f, 13))
    lifting, numbers, _ = BatchedFunction.parametrised(f)
    ours, theirs = (
        BatchedFunction(lifting, parameters=numbers),
        BatchedFunction(f, backend="interpreter"),
    )
    z = states(f, 13, seed=1)
    np.testing.assert_allclose(ours(*z)[0], theirs(*z)[0], rtol=1e-11, atol=1e-10)


@pytest.mark.parametrize("joints, feet", [("43", "two-segment"), ("66", "multi-segment")])
def test_people_with_the_same_joints_differ_in_numbers_only(joints, feet):
    def structure(*size):
        body = SymbolicHuman(Human.create(*size, joints=joints, feet=feet))
        return BatchedFunction.parametrised(body.inverse_dynamics(list(foot_sites(body.human))))

    (_, one, first), (_, two, second) = structure(1.6, 51.0), structure(1.93, 97.0)
    assert first == second
    assert len(one) == len(two) and not np.allclose(one, two)


def test_other_formulas_are_distinguished():
    def structure(f):
        return BatchedFunction.parametrised(ca.Function("f", [x, y], [f]))[2]

    assert structure(1.3 * x) == structure(2.7 * x)
    different = [1.3 * x, 1.3 * y, 2 * x, -x, 3 * x, 1.3 + x, x**1.3, x**2.7, 1.3 * ca.sin(x)]
    assert len({structure(f) for f in different}) == len(different)


def forbid(*_):
    raise AssertionError("this should not have been needed")


@needs_llvm
def test_a_table_is_found_on_disk_and_nothing_is_made_again(folder, monkeypatch):
    z = states(EVERYTHING, 5)
    before = BatchedFunction(lambda: EVERYTHING, key="everything")(*z)
    assert len(list(folder.iterdir())) == 1
    monkeypatch.setattr(tables, "tabulated", forbid)
    again = BatchedFunction(forbid, key="everything")  # type: ignore[arg-type]
    np.testing.assert_array_equal(again(*z)[0], before[0])
    assert again.pattern(0)[0].tolist() == list(range(50))


@needs_llvm
@pytest.mark.parametrize("harm", ["cut", "changed", "foreign", "empty", "folder"])
def test_a_harmed_file_is_made_again(folder, harm):
    z = states(EVERYTHING, 5)
    before = BatchedFunction(EVERYTHING, key="everything")(*z)
    (file,) = folder.iterdir()
    good = file.read_bytes()
    middle = len(good) // 2
    if harm == "folder":
        file.unlink()
        file.mkdir()
    else:
        file.write_bytes(
            {
                "cut": good[:middle],
                "changed": good[:middle] + b"?" + good[middle + 1 :],
                "foreign": b"a shopping list",
                "empty": b"",
            }[harm]
        )
    again = BatchedFunction(EVERYTHING, key="everything")(*z)
    np.testing.assert_array_equal(again[0], before[0])
    if harm != "folder":
        assert file.read_bytes() == good
    assert [p.name for p in folder.iterdir()] == [file.name]


def test_without_a_folder_nothing_is_kept(folder, monkeypatch):
    monkeypatch.setenv(CACHE, "")
    BatchedFunction(EVERYTHING, key="everything")(*states(EVERYTHING, 2))
    assert not folder.exists()
    monkeypatch.setenv(CACHE, str(folder.parent / "file" / "below"))
    (folder.parent / "file").write_text("not a folder")
    BatchedFunction(EVERYTHING, key="everything")(*states(EVERYTHING, 2))


def test_what_the_machine_does_not_know_is_interpreted():
    z = ca.MX.sym("z", 2)
    for f, why in (
        (ca.Function("f", [x], [ca.erfinv(x)]), "erfinv"),
        (ca.Function("f", [z], [ca.sin(z)]), "not of SX"),
    ):
        b = BatchedFunction(f)
        assert b.backend == "interpreter"
        at = np.full((3, f.size1_in(0)), 0.25)
        np.testing.assert_allclose(b(*[at])[0][0], np.array(f(at[0])).ravel())
        if not BatchedFunction.unavailable():
            assert why in b.reason
            with pytest.raises(ParameterError, match=f"vectors are not available: .*{why}"):
                BatchedFunction(f, backend="vectors")


@needs_llvm
def test_without_functions_of_the_c_library_functions_are_interpreted(monkeypatch):
    monkeypatch.setattr(vector_machine, "LIBRARY_NAMES", ("sin", "no_such_function"))
    b = BatchedFunction(EVERYTHING)
    assert b.backend == "interpreter" and "no_such_function" in b.reason


def test_without_llvmlite_functions_are_interpreted(monkeypatch):
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    monkeypatch.delitem(sys.modules, "llvmlite.binding", raising=False)
    b = BatchedFunction(EVERYTHING)
    assert (b.backend, b.reason) == ("interpreter", "llvmlite is not installed")
    assert b(*states(EVERYTHING, 3))[0].shape == (3, 50)


@pytest.mark.parametrize("backend", [pytest.param("vectors", marks=needs_llvm), "interpreter"])
def test_outputs_are_scattered_and_wrong_arrays_are_refused(backend):
    v = ca.SX.sym("v", 2)
    f = BatchedFunction(ca.Function("f", [v], [ca.vertcat(v, v[0] * v[1])]), backend=backend)
    at = np.array([[2.0, 3.0], [5.0, 7.0], [1.0, 0.5]])
    into = np.full((3, 2, 2), -1.0)
    places = (np.array([0, 2, 2]), np.array([3, 0, 1]))
    f.scatter([at], [into], [places])
    np.testing.assert_array_equal(into[1], [[35.0, 35.0], [-1.0, 5.0]])
    with pytest.raises(ParameterError, match="sources and places must be"):
        f.scatter([at], [into], [(np.array([3]), np.array([0]))])
    with pytest.raises(ParameterError, match="sources and places must be"):
        f.scatter([at], [into], [(np.array([0]), np.array([4]))])
    with pytest.raises(ParameterError, match="contiguous arrays"):
        f.scatter([at], [into.transpose(0, 2, 1)], [places])
    with pytest.raises(ParameterError, match="3 nodes need"):
        f(at[:, :1])
    with pytest.raises(ParameterError, match="takes 1 inputs, not 2"):
        f(at, at)


def test_a_function_of_matrices_is_refused():
    m = ca.SX.sym("m", 2, 2)
    with pytest.raises(ParameterError, match="only dense columns"):
        BatchedFunction(ca.Function("f", [m], [m[0, 0]]))
    with pytest.raises(ParameterError, match="must be one of"):
        BatchedFunction(EVERYTHING, backend="C")


def test_a_function_outlives_the_memory_of_machines():
    """What was made before is still run after machines have been forgotten."""
    import gc

    x = ca.SX.sym("x", 3)
    made = BatchedFunction(ca.Function("cubes", [x], [x**3 + ca.sin(x)]), backend="vectors")
    points = np.linspace(-1.0, 1.0, 21 * 3).reshape(21, 3)
    before = made(points)[0]
    vector_machine._machine.cache_clear()
    gc.collect()
    np.testing.assert_array_equal(made(points)[0], before)


@pytest.mark.parametrize("backend", [pytest.param("vectors", marks=needs_llvm), "interpreter"])
def test_threads_do_not_disturb_each_other(backend):
    """Many calls at once, of as many nodes each, give what one call after the other gives."""
    v = ca.SX.sym("v", 4)
    chain = v
    for _ in range(200):
        chain = ca.sin(chain) + 0.3 * v[::-1] * chain
    f = BatchedFunction(ca.Function("f", [v], [chain]), backend=backend)
    rng = np.random.default_rng(0)
    calls = [rng.normal(size=(n, 4)) for n in (61, 61, 17, 61, 5, 61, 130, 61) * 10]
    expected = [f(each)[0] for each in calls]
    with ThreadPoolExecutor(8) as pool:
        for ours, alone in zip(pool.map(lambda at: f(at)[0], calls), expected, strict=True):
            np.testing.assert_array_equal(ours, alone)
