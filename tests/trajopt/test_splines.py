"""Splines against the printed equations taken literally, automatic differentiation and SciPy."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import BSpline

from plantigrade.errors import ParameterError
from plantigrade.trajopt.splines.knots import clamped_knots, periodic_knots
from plantigrade.trajopt.splines.polynomial import PolynomialBasis
from plantigrade.trajopt.splines.trigonometric import TrigonometricBasis

KINDS = [TrigonometricBasis, PolynomialBasis]
BREAKS = np.array([0.3, 0.5, 0.5, 1.1, 1.2, 1.2, 1.2, 1.7, 2.0, 2.6])  # uneven, some repeated


def uniform(start, stop, pieces, degree):
    """Return evenly spaced knots that extend past both ends."""
    steps = np.arange(-degree, pieces + degree + 1)
    knots = start + (stop - start) * (steps / pieces)
    knots[degree + pieces] = stop  # exactly
    return knots


KNOTS = {
    "clamped": lambda degree: clamped_knots(BREAKS, degree),
    "uniform": lambda degree: uniform(0.3, 2.6, 7, degree),
    "uneven": lambda degree: np.concatenate(
        [0.3 - 0.1 * np.arange(degree, 0, -1), BREAKS, 2.6 + 0.2 * np.arange(1, degree + 1)]
    ),
}
TIMES = np.setdiff1d(np.linspace(0.3, 2.6, 25), BREAKS)  # inside the pieces
FEW = np.array([0.4, 0.8, 1.15, 1.5, 2.4])
FINE = np.linspace(0.3, 2.6, 301)

# The paper's equations word for word, in scaled time t, which may be complex or symbolic; `now` is
# its real value, t_l is k[l] and gamma is g.


def eq_5(t, now, k, i, g):
    if g == 0:
        return float(k[i] <= now < k[i + 1])
    value = 0.0
    if np.sin(k[i + g] - k[i]) != 0:  # Eq. 6
        value = value + np.sin(t - k[i]) / np.sin(k[i + g] - k[i]) * eq_5(t, now, k, i, g - 1)
    if np.sin(k[i + g + 1] - k[i + 1]) != 0:
        value = value + (
            np.sin(k[i + g + 1] - t)
            / np.sin(k[i + g + 1] - k[i + 1])
            * eq_5(t, now, k, i + 1, g - 1)
        )
    return value


def over(numerator, *angles):
    sines = np.sin(angles)
    return numerator / np.prod(sines) if np.all(sines != 0) else 0.0


def eq_7(t, now, k, i, g):
    rise = over(np.cos(t - k[i]), k[i + g] - k[i]) * eq_5(t, now, k, i, g - 1)
    fall = over(np.cos(k[i + g + 1] - t), k[i + g + 1] - k[i + 1]) * eq_5(t, now, k, i + 1, g - 1)
    return g * (rise - fall)


def eq_8(t, now, k, i, g):
    low, high = k[i + g] - k[i], k[i + g + 1] - k[i + 1]
    sines = over(np.sin(t - k[i]), low) * eq_5(t, now, k, i, g - 1)
    sines += over(np.sin(k[i + g + 1] - t), high) * eq_5(t, now, k, i + 1, g - 1)
    cosines = over(np.cos(t - k[i]) ** 2, low, k[i + g - 1] - k[i]) * eq_5(t, now, k, i, g - 2)
    cosines -= over(np.cos(t - k[i]) * np.cos(k[i + g] - t), low, k[i + g] - k[i + 1]) * eq_5(
        t, now, k, i + 1, g - 2
    )
    cosines -= over(
        np.cos(t - k[i + 1]) * np.cos(k[i + g + 1] - t), k[i + g] - k[i + 1], high
    ) * eq_5(t, now, k, i + 1, g - 2)
    cosines += over(np.cos(k[i + g + 1] - t) ** 2, high, k[i + g + 1] - k[i + 2]) * eq_5(
        t, now, k, i + 2, g - 2
    )
    return -g * sines + g * (g - 1) * cosines


def literally(equation, basis, times=TIMES, step=0.0):
    """Evaluate an equation for all times and functions, the time moved by an imaginary step."""
    k = basis.rate * (basis.knots - basis.start)
    scaled = basis.rate * (times - basis.start)
    moved = scaled + 1j * step if step else scaled
    return np.array(
        [
            [equation(t, now, k, i, basis.degree) for i in range(basis.n_coefficients)]
            for t, now in zip(moved, scaled, strict=True)
        ]
    )


def complex_step(equation, basis):
    """Differentiate an equation without a difference, so to rounding."""
    return literally(equation, basis, step=1e-30).imag / 1e-30


def dense(basis, times, derivative=0, **options):
    return basis.matrix(times, derivative, **options).toarray()


def cases(lowest, highest):
    """Every kind of knots with every degree that the repeated knots leave room for."""
    return [
        pytest.param(degree, KNOTS[name](degree), id=f"{name}-{degree}")
        for name in KNOTS
        for degree in range(lowest, highest + 1)
        if degree >= 2 or name == "uniform"
    ]


@pytest.mark.parametrize(("degree", "knots"), cases(0, 5))
def test_values_are_equations_5_and_6(degree, knots):
    basis = TrigonometricBasis(degree, knots)
    np.testing.assert_allclose(dense(basis, TIMES), literally(eq_5, basis), atol=1e-14)


@pytest.mark.parametrize(("degree", "knots"), cases(1, 5))
def test_equation_7_is_the_derivative_of_equation_5(degree, knots):
    basis = TrigonometricBasis(degree, knots)
    truth = complex_step(eq_5, basis)
    np.testing.assert_allclose(literally(eq_7, basis), truth, atol=1e-13)
    np.testing.assert_allclose(dense(basis, TIMES, 1) / basis.rate, truth, atol=1e-13)


@pytest.mark.parametrize(("degree", "knots"), cases(2, 5))
def test_equation_8_is_right_as_printed(degree, knots):
    basis = TrigonometricBasis(degree, knots)
    truth = complex_step(eq_7, basis)
    tolerance = 1e-13 * np.abs(truth).max()
    np.testing.assert_allclose(literally(eq_8, basis), truth, atol=tolerance)
    np.testing.assert_allclose(dense(basis, TIMES, 2) / basis.rate**2, truth, atol=tolerance)


@pytest.mark.parametrize(("degree", "knots"), cases(2, 4))
def test_jerk_is_the_derivative_of_equation_8(degree, knots):
    basis = TrigonometricBasis(degree, knots)
    truth = complex_step(eq_8, basis)
    tolerance = 1e-13 * np.abs(truth).max()
    np.testing.assert_allclose(dense(basis, TIMES, 3) / basis.rate**3, truth, atol=tolerance)


@pytest.mark.filterwarnings("ignore::FutureWarning")
def test_symbolic_differentiation_of_equation_5_agrees_twice():
    ca = pytest.importorskip("casadi")
    basis = TrigonometricBasis(3, KNOTS["clamped"](3))
    k, t = basis.rate * (basis.knots - basis.start), ca.SX.sym("t")
    for time in FEW:
        now = basis.rate * (time - basis.start)
        values = ca.vertcat(*[eq_5(t, now, k, i, 3) for i in range(basis.n_coefficients)])
        first = ca.jacobian(values, t)
        second = ca.Function("f", [t], [first, ca.jacobian(first, t)])(now)
        for derivative, truth in enumerate(second, start=1):
            found = dense(basis, np.array([time]), derivative)[0] / basis.rate**derivative
            np.testing.assert_allclose(found, np.array(truth)[:, 0], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("derivative", range(5))
@pytest.mark.parametrize(("degree", "knots"), cases(0, 5))
def test_polynomials_are_those_of_scipy(degree, knots, derivative):
    basis = PolynomialBasis(degree, knots)
    functions = BSpline(knots, np.eye(basis.n_coefficients), degree)
    truth = functions(TIMES, derivative)
    scale = max(1.0, np.abs(truth).max())
    np.testing.assert_allclose(dense(basis, TIMES, derivative), truth, atol=1e-12 * scale)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_the_smaller_the_angle_the_nearer_to_polynomials(degree):
    knots = clamped_knots(BREAKS, degree)
    polynomial = dense(PolynomialBasis(degree, knots), TIMES)
    coarse, fine = (
        np.abs(dense(TrigonometricBasis(degree, knots, angle=angle), TIMES) - polynomial).max()
        for angle in (0.2, 0.1)
    )
    assert fine < 3e-3 and coarse / fine == pytest.approx(4, rel=0.05)  # with its square


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("degree", "knots"), cases(0, 4))
def test_support_is_local_and_functions_positive_in_it(kind, degree, knots):
    basis = kind(degree, knots)
    values = dense(basis, TIMES)
    for i in range(basis.n_coefficients):
        start, stop = basis.knots[[i, i + degree + 1]]
        inside = (TIMES > start) & (TIMES < stop)
        assert (values[inside, i] > 0).all() and (values[~inside, i] == 0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_the_band_is_the_matrix(kind):
    basis = kind(3, KNOTS["clamped"](3))
    band, matrix = basis.band(FINE, 2), dense(basis, FINE, 2)
    assert band.values.shape == (301, 4)
    assert (np.take_along_axis(matrix, band.columns, axis=1) == band.values).all()
    np.put_along_axis(matrix, band.columns, 0, axis=1)
    assert not matrix.any()
    assert basis.matrix(FINE, 2).nnz == 4 * 301  # zeros are kept: the pattern is that of the times


@pytest.mark.parametrize(("degree", "knots"), cases(0, 5))
def test_polynomials_sum_to_one(degree, knots):
    basis = PolynomialBasis(degree, knots)
    np.testing.assert_allclose(basis.matrix(FINE) @ basis.unity(), 1, atol=1e-13)
    np.testing.assert_allclose(basis.matrix(FINE).sum(axis=1), 1, atol=1e-13)


@pytest.mark.parametrize(("degree", "knots"), cases(0, 5))
def test_harmonics_of_the_space_are_exact(degree, knots):
    basis = TrigonometricBasis(degree, knots)
    theta = basis.rate * (FINE - basis.start)
    for k in range(degree, -1, -2):
        for derivative in range(3):
            matrix = basis.matrix(FINE, derivative)
            cosine, sine = basis.harmonic(k)
            turn = (1j * k * basis.rate) ** derivative * np.exp(1j * k * theta)
            scale = max(1.0, np.abs(matrix.data).max())
            np.testing.assert_allclose(matrix @ cosine, turn.real, atol=1e-13 * scale)
            np.testing.assert_allclose(matrix @ sine, turn.imag, atol=1e-13 * scale)


@pytest.mark.parametrize("degree", [2, 4])
def test_even_degrees_hold_a_pose_exactly_with_coefficients_below_one(degree):
    basis = TrigonometricBasis(degree, clamped_knots(BREAKS, degree))
    unity = basis.unity()
    np.testing.assert_allclose(basis.matrix(FINE) @ unity, 1, atol=1e-13)
    assert (unity > 0).all() and (unity <= 1 + 1e-15).all() and unity.min() < 0.99


@pytest.mark.parametrize(
    ("n_pieces", "surplus", "error"),
    [(6, 0.1892, 2.1e-4), (30, 6.70e-3, 3.3e-7), (60, 1.67e-3, 2.1e-8)],
)
def test_cubic_functions_do_not_sum_to_one_and_no_pose_is_exact(n_pieces, surplus, error):
    # The figures of the docstring, for who chooses between bases.
    basis = TrigonometricBasis(3, clamped_knots(np.linspace(0, 3, n_pieces + 1)), angle=2.0)
    matrix = basis.matrix(np.linspace(0, 3, 1201))
    sums = matrix.sum(axis=1)
    assert sums.min() == pytest.approx(1) and sums.max() - 1 == pytest.approx(surplus, rel=0.01)
    left = np.abs(matrix @ basis.unity() - 1).max()
    assert 0.5 * error < left < error


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("degree", [2, 3, 4])
def test_ends_of_clamped_splines_belong_to_the_outermost_coefficients(kind, degree):
    basis = kind(degree, clamped_knots(BREAKS, degree))
    ends = np.array([basis.start, basis.stop])
    for derivative in range(degree):
        first, last = dense(basis, ends, derivative)
        assert first[derivative] and not first[derivative + 1 :].any()
        assert last[-1 - derivative] and not last[: -1 - derivative].any()
    np.testing.assert_allclose(dense(basis, ends)[[0, 1], [0, -1]], 1)  # the last piece is closed


@pytest.mark.parametrize("kind", KINDS)
def test_smoothness_at_a_knot_is_degree_less_multiplicity(kind):
    basis = kind(4, clamped_knots(BREAKS, 4))
    for knot, multiplicity in ((1.1, 1), (0.5, 2), (1.2, 3)):
        at = np.array([knot])
        for derivative in range(5):
            left, right = (dense(basis, at, derivative, side=s) for s in ("left", "right"))
            smooth = np.allclose(left, right, atol=1e-10 * np.abs(left).max())
            assert smooth == (derivative <= 4 - multiplicity)
            before, after = (dense(basis, at + d, derivative) for d in (-1e-9, 1e-9))
            scale = np.abs(before).max() + np.abs(after).max()
            np.testing.assert_allclose(left, before, atol=1e-6 * scale)
            np.testing.assert_allclose(right, after, atol=1e-6 * scale)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_a_periodic_spline_comes_round(kind, degree, side):
    breaks = np.array([0.2, 0.3, 0.45, 0.6, 0.8, 0.9, 1.1, 1.3])
    basis = kind(degree, periodic_knots(breaks, degree), periodic=True)
    assert basis.n_coefficients == 7 and basis.span == pytest.approx(1.1)
    c = np.random.default_rng(0).normal(size=7)
    times = np.linspace(0.21, 1.29, 40)
    for derivative in range(3):
        once = basis.matrix(times, derivative, side=side) @ c
        for turns in (-3, 1):
            again = basis.matrix(times + turns * 1.1, derivative, side=side) @ c
            np.testing.assert_allclose(again, once, atol=1e-9 * np.abs(once).max())
    for derivative in range(degree):  # and the seam is a knot like any other
        before, after = basis.matrix(np.array([1.3 - 1e-9, 1.3 + 1e-9]), derivative) @ c
        assert before == pytest.approx(after, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("repeated", [[0, 0, 0.3, 0.6, 0.8, 1], [0, 0.3, 0.6, 0.8, 1, 1]])
def test_the_seam_may_be_a_switch(kind, repeated):
    breaks = np.array(repeated, dtype=float)
    basis = kind(3, periodic_knots(breaks, 3), periodic=True)
    at = np.zeros(1)
    for derivative, smooth in ((0, True), (1, True), (2, False)):
        left, right = (dense(basis, at, derivative, side=s) for s in ("left", "right"))
        assert np.allclose(left, right) == smooth
        for found, time in ((left, -1e-9), (right, 1e-9)):
            near = dense(basis, at + time, derivative)
            np.testing.assert_allclose(found, near, atol=1e-6 * np.abs(near).max())


@pytest.mark.parametrize("kind", KINDS)
def test_supports_of_a_periodic_basis_go_round(kind):
    basis = kind(2, periodic_knots(np.linspace(0, 1, 7), 2), periodic=True)
    times = np.linspace(0.01, 0.99, 31)
    values = dense(basis, times)
    for i in range(6):
        start, stop = basis.knots[[i, i + 3]]
        inside = np.zeros(31, dtype=bool)
        for turns in (0, 1):
            inside |= (times + turns > start + 1) & (times + turns < stop + 1)
        inside |= (times > start) & (times < stop)
        assert ((values[:, i] > 0) == inside).all()


def test_an_even_degree_over_half_a_turn_holds_the_cycle_and_its_mean_exactly():
    times = np.linspace(0, 1.2, 50)
    knots = periodic_knots(np.linspace(0, 1.2, 13), 4)
    basis = TrigonometricBasis(4, knots, angle=np.pi, periodic=True)
    np.testing.assert_allclose(basis.matrix(times) @ basis.unity(), 1, atol=1e-13)
    for k in (2, 4):  # of the angle: the first and second harmonic of the cycle
        phase = k * np.pi * times / 1.2
        cosine, sine = basis.harmonic(k)
        np.testing.assert_allclose(basis.matrix(times) @ cosine, np.cos(phase), atol=1e-13)
        np.testing.assert_allclose(basis.matrix(times) @ sine, np.sin(phase), atol=1e-13)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_fit_gives_a_spline_of_the_space_back(kind, periodic):
    breaks = np.linspace(0, 3, 13)
    knots = periodic_knots(breaks) if periodic else clamped_knots(breaks)
    basis = kind(3, knots, periodic=periodic)
    c = np.random.default_rng(1).normal(size=(basis.n_coefficients, 2, 3))
    times = np.linspace(0, 3, 60)
    values = np.tensordot(dense(basis, times), c, axes=1)
    np.testing.assert_allclose(basis.fit(times, values), c, atol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_fit_of_a_smooth_curve_converges_with_the_fourth_power(kind):
    times = np.linspace(0, 2, 400)
    curve = np.exp(np.sin(3 * times))
    errors = []
    for n in (21, 41):
        basis = kind(3, clamped_knots(np.linspace(0, 2, n)))
        errors.append(np.abs(basis.matrix(times) @ basis.fit(times, curve) - curve).max())
    assert errors[1] < 1e-5 and errors[0] / errors[1] > 12


@pytest.mark.parametrize("kind", KINDS)
def test_one_sample_at_each_node_leaves_two_coefficients_open_until_smoothed(kind):
    nodes = np.linspace(0, 3, 13)
    basis = kind(3, clamped_knots(nodes))
    line = 0.2 + 0.1 * nodes
    with pytest.raises(ParameterError, match="settle 13 of 15 .* smoothing > 0"):
        basis.fit(nodes, line)
    c = basis.fit(nodes, line, smoothing=1e-6)
    np.testing.assert_allclose(basis.matrix(nodes) @ c, line, atol=1e-4)
    assert np.abs(basis.matrix(np.linspace(0, 3, 200), 2) @ c).max() < 0.05


@pytest.mark.parametrize("kind", KINDS)
def test_matrices_are_computed_once_and_cannot_be_changed(kind, monkeypatch):
    basis = kind(3, clamped_knots(np.linspace(0, 1, 11)))
    times = np.linspace(0, 1, 21)
    first = basis.matrix(times, 1)
    monkeypatch.setattr(basis, "evaluate", None)  # a second evaluation would fail
    assert basis.matrix(times.copy(), 1) is first
    with pytest.raises(ValueError, match="read-only"):
        first.data[0] = 7
    with pytest.raises(ValueError, match="read-only"):
        basis.knots[0] = 7
    for _ in range(200):
        monkeypatch.undo()
        basis.matrix(times + np.random.default_rng(_).uniform(-1e-12, 1e-12))
    assert len(basis._bands) <= 64


@pytest.mark.parametrize("kind", KINDS)
def test_equal_bases_are_equal_also_between_processes(kind):
    knots = clamped_knots(np.linspace(0, 1, 11))
    basis, twin = kind(3, knots), kind(3, knots.copy())
    assert basis == twin and hash(basis) == hash(twin)
    assert pickle.loads(pickle.dumps(basis)) == basis
    assert basis != kind(3, clamped_knots(np.linspace(0, 1, 12)))
    assert TrigonometricBasis(3, knots) != PolynomialBasis(3, knots)
    assert TrigonometricBasis(3, knots, angle=1) != TrigonometricBasis(3, knots)
    assert "degree 3, 13 coefficients, 0 to 1 s" in repr(basis)


@pytest.mark.parametrize("kind", KINDS)
def test_no_times_no_rows(kind):
    assert kind(3, clamped_knots(np.linspace(0, 1, 5))).matrix(np.zeros(0), 1).shape == (0, 7)


@given(
    gaps=arrays(float, st.integers(3, 12), elements=st.floats(0.01, 1)),
    degree=st.integers(0, 5),
    angle=st.floats(0.01, 3.1),
)
def test_any_clamped_knots_carry_the_first_harmonic_or_the_constant(gaps, degree, angle):
    breaks = np.concatenate([[0.0], np.cumsum(gaps)])
    basis = TrigonometricBasis(degree, clamped_knots(breaks, degree), angle=angle)
    times = np.linspace(0, breaks[-1], 40)
    k = degree % 2
    cosine, _ = basis.harmonic(k)
    matrix = basis.matrix(times)
    assert matrix.data.min() > -1e-12
    scale = max(1.0, np.abs(matrix).max() * np.abs(cosine).max())
    truth = np.cos(k * angle * times / breaks[-1])
    np.testing.assert_allclose(matrix @ cosine, truth, atol=1e-11 * scale)


BAD = {
    "back in time: 0.4 s follows 0.5 s": lambda: clamped_knots(np.array([0, 0.5, 0.4, 1])),
    "finite": lambda: clamped_knots(np.array([0, np.nan, 1])),
    "span no time": lambda: clamped_knots(np.array([1.0, 1.0])),
    "whole number": lambda: clamped_knots(np.array([0.0, 1.0]), -1),
    "3 pieces in a period are too few": lambda: periodic_knots(np.linspace(0, 1, 4)),
}


@pytest.mark.parametrize("words", BAD)
def test_bad_breaks_are_refused(words):
    with pytest.raises(ParameterError, match=words):
        BAD[words]()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("knots", "words"),
    [
        ([0, 0, 0, 0, 1, 1, 1], "7 knots are too few for a spline of degree 3.*8 or more"),
        ([0, 0, 0, 0, 0.5, 0.4, 1, 1, 1, 1], "back in time: 0.4 s follows 0.5 s"),
        ([0, 0, 0, 0, 0, 1, 1, 1, 1], "at 0 s occurs more than 4 times"),
        ([0, 0, 0, 0, 0.5, 0.5, 0.5, 0.5, 0.5, 1, 1, 1, 1], "at 0.5 s occurs more than 4"),
        ([-2, -1, 0, 0.5, 0.5, 1, 1.5, 2, 3, 4], "first or last basis function"),
        ([-3, -2, -1, 0, 0, 1, 1.5, 2, 3, 4], "first or last basis function"),
    ],
)
def test_bad_knots_are_refused(kind, knots, words):
    knots = np.array(knots, dtype=float)
    with pytest.raises(ParameterError, match=words):
        kind(3, knots)


@pytest.mark.parametrize("kind", KINDS)
def test_bad_requests_are_refused(kind):
    basis = kind(3, clamped_knots(np.linspace(0, 2, 9)))
    with pytest.raises(ParameterError, match="time 2.1 s lies outside .* 0 to 2 s"):
        basis.matrix(np.array([0.0, 2.1]))
    with pytest.raises(ParameterError, match="finite"):
        basis.matrix(np.array([np.nan]))
    basis.matrix(np.array([-1e-12, 2 + 1e-12]))  # rounding is forgiven
    with pytest.raises(ParameterError, match="derivative"):
        basis.matrix(np.array([0.0]), -1)
    with pytest.raises(ParameterError, match="all finite"):
        basis.fit(np.linspace(0, 2, 3), np.array([0, np.inf, 0]))
    with pytest.raises(ParameterError, match="negative"):
        basis.fit(np.linspace(0, 2, 3), np.zeros(3), smoothing=-1)
    with pytest.raises(ParameterError, match="make them with periodic_knots"):
        kind(3, clamped_knots(np.linspace(0, 2, 9)), periodic=True)


@pytest.mark.parametrize("angle", [0, -1, np.pi, 4, np.nan, np.inf])
def test_the_span_stays_below_half_a_turn(angle):
    with pytest.raises(ParameterError, match="must be above 0 and below pi"):
        TrigonometricBasis(3, clamped_knots(np.linspace(0, 2, 9)), angle=angle)


def test_every_support_stays_below_half_a_turn():
    with pytest.raises(ParameterError, match="spans 4 rad, and pi is the limit.* below 1.57 rad"):
        TrigonometricBasis(3, uniform(0, 1, 2, 3))
    with pytest.raises(ParameterError, match="spans 4.19 rad"):
        knots = periodic_knots(np.linspace(0, 1, 7))
        TrigonometricBasis(3, knots, angle=2 * np.pi, periodic=True)


def test_harmonics_the_space_has_not_are_refused():
    basis = TrigonometricBasis(3, clamped_knots(np.linspace(0, 2, 9)))
    with pytest.raises(ParameterError, match="harmonic 2 is not in degree 3, which has 1, 3"):
        basis.harmonic(2)
    cyclic = TrigonometricBasis(3, periodic_knots(np.linspace(0, 2, 9)), periodic=True)
    with pytest.raises(ParameterError, match="turns 0.318.* times in a period"):
        cyclic.harmonic(1)
