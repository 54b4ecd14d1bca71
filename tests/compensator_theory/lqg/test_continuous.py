"""Continuous LQG: SciPy's and python-control's Riccati solvers, mpmath's Hamiltonian, loci."""

import control
import mpmath
import numpy as np
import pytest
import scipy.linalg
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import compensator_theory as ct
from compensator_theory.errors import ImproperError, NoSolutionError, NotControllableError
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.strategies import matrices, minimal_plants, polynomials

R_2 = sympy.Symbol("R_2")


def as_float(matrix):
    return np.array(sympy.Matrix(matrix).tolist(), dtype=float)


def centres(rows):
    return np.array([[float(c) for c in row] for row in rows])


@st.composite
def regulators(draw):
    """Controllable pairs, a cost that has no zero on the axis: the last row of z is u alone."""
    plant = draw(minimal_plants(3))
    A, B, C = plant.A, plant.B, plant.C
    E_1 = C.col_join(draw(matrices(1, A.rows))).col_join(sympy.zeros(1, A.rows))
    weight = draw(st.sampled_from([sympy.Rational(1, 3), 1, 2]))
    return A, B, E_1, sympy.Matrix([0, *draw(matrices(1, 1)), weight])


def solved(data):
    try:
        A, B, E_1, E_2 = data
        return ct.solve_riccati(A, B, E_1=E_1, E_2=E_2, time="continuous")
    except NoSolutionError:  # drawn with a zero on the axis
        return None


@given(regulators())
def test_gain_and_cost_against_scipy(data):
    solution = solved(data)
    if solution is None:
        return
    A, B, E_1, E_2 = map(as_float, data)
    P = scipy.linalg.solve_continuous_are(A, B, E_1.T @ E_1, E_2.T @ E_2, s=E_1.T @ E_2)
    scale = 1 + np.abs(P).max()
    assert np.allclose(centres(solution.P_enclosure), P, atol=1e-6 * scale, rtol=1e-6)
    K = -np.linalg.solve(E_2.T @ E_2, B.T @ P + E_2.T @ E_1)
    assert np.allclose(centres(solution.K_enclosure), K, atol=1e-6 * scale, rtol=1e-6)


@given(regulators())
def test_residual_and_poles_are_certified(data):
    solution = solved(data)
    if solution is None:
        return
    for row in solution.residual:
        assert all(0 in entry for entry in row)
        assert max(float(entry.radius) for entry in row) < 1e-15
    assert all(0 in c for c in solution.factor.residual)
    assert solution.is_exact and solution.certificate.holds
    if solution.is_rational:
        closed = characteristic_polynomial(
            data[0] + data[1] * solution.K, solution.factor.polynomial.gen
        )
        assert closed == solution.factor.polynomial


def test_fifty_digits_against_the_stable_subspace_of_the_hamiltonian():
    A, B = sympy.Matrix([[0, 1, 0], [0, 0, 1], [-1, 2, 3]]), sympy.Matrix([0, 0, 1])
    E_1, E_2 = sympy.Matrix([[1, 2, 0], [0, 0, 0]]), sympy.Matrix([0, 3])
    solution = ct.solve_riccati(A, B, E_1=E_1, E_2=E_2, digits=50, time="continuous")
    with mpmath.workdps(90):
        a, b, r = mpmath.matrix(A.tolist()), mpmath.matrix(B.tolist()), mpmath.mpf(9)
        q = mpmath.matrix((E_1.T * E_1).tolist())
        H = mpmath.matrix(6, 6)
        H[:3, :3], H[:3, 3:], H[3:, :3], H[3:, 3:] = a, -b * b.T / r, -q, -a.T
        values, vectors = mpmath.eig(H)
        stable = [k for k in range(6) if values[k].real < 0]
        X = mpmath.matrix([[vectors[i, k] for k in stable] for i in range(6)])
        P = X[3:, :] * X[:3, :] ** -1
        for i in range(3):
            for j in range(3):
                entry = solution.P_enclosure[i][j]
                centre = mpmath.mpf(int(entry.centre.p)) / int(entry.centre.q)
                assert abs(P[i, j] - centre) < mpmath.mpf(10) ** -48
                assert entry.radius <= sympy.Rational(1, 10**50)


PLANT = ct.StandardProblem(
    A=[[0, 1], [2, -1]], B=[[0], [1]], C=[[1, 1]], D_1=[[1, 0], [2, 0]], D_0=[["1/2"]],
    D_2=[["1/3", 1]], E_1=[[1, 0], [0, 0]], E_2=[["1/5"], [1]], E_0=None, variable="s",
)  # fmt: skip


def test_the_whole_controller_against_python_control():
    controller = ct.lqg_controller(PLANT)
    A, B, C, D_1, D_2, E_1, E_2 = (
        as_float(getattr(PLANT, name)) for name in ("A", "B", "C", "D_1", "D_2", "E_1", "E_2")
    )
    K, _, regulator = control.lqr(A, B, E_1.T @ E_1, E_2.T @ E_2, E_1.T @ E_2)
    L, _, estimator = control.lqr(A.T, C.T, D_1 @ D_1.T, D_2 @ D_2.T, D_1 @ D_2.T)
    assert np.allclose(centres(controller.regulator.K_enclosure), -K)
    assert np.allclose(centres(controller.estimator.K_enclosure), -L)
    expected = np.poly([*regulator, *estimator]).real
    assert np.allclose([float(c) for c in controller.enclosure.coefficients], expected)


def test_a_rational_controller_closes_the_loop_that_it_says():
    """A double integrator with both spectra rational, by r = 1/4 and the intensity 4."""
    plant = ct.StandardProblem(
        A=[[0, 1], [0, 0]], B=[[0], [1]], C=[[1, 0]], D_1=[[0, 0], [2, 0]], D_0=[[3]],
        D_2=[[0, 1]], E_1=[[1, 0], [0, 0]], E_2=[[0], ["1/2"]], E_0=None, variable="s",
    )  # fmt: skip
    controller = ct.lqg_controller(plant)
    assert controller.polynomial == ct.polynomial("(s**2 + 2*s + 2)**2")
    G_c = controller.compensator
    N, D = ct.polynomial("1 + 3*s**2"), ct.polynomial("s**2")
    assert D * G_c.denominator - N * G_c.numerator == controller.polynomial


@given(polynomials(max_degree=3), polynomials(min_degree=1, max_degree=4), st.sampled_from([1, 3]))
def test_half_plane_factors_have_the_spectrum(N, D, r):
    try:
        factor = ct.spectral_factor(N, D, r, time="continuous")
    except NoSolutionError:
        return
    assert all(0 in c for c in factor.residual)
    roots = np.roots([float(c) for c in factor.enclosure.coefficients])
    assert all(root.real < 1e-6 for root in roots)


@pytest.mark.parametrize("weight", ["1/1000000000000", "1/100", 7, 10**12])
@pytest.mark.parametrize(
    ("N", "D"),
    [("s - 1", "(s + 1)*(s - 2)"), ("2", "s**2*(s + 1)"), ("z - 2", "(z - 3)*(z - 1/3)")],
)
def test_loci_meet_their_limits(N, D, weight):
    locus, r = ct.regulator_locus(N, D), sympy.Rational(weight)
    chi = np.array([float(c) for c in locus.at(r).enclosure.coefficients])
    spectrum = locus.spectrum.as_expr().subs(R_2, r)
    x = locus.denominator.gen
    residuals = [abs(complex(spectrum.subs(x, root).evalf(60)) / complex(spectrum.diff(x).subs(
        x, root))) for root in np.roots(chi)]  # fmt: skip
    assert max(residuals) < 1e-6 * max(1, np.abs(np.roots(chi)).max())
    finite = [float(c) for c in locus.cheap.enclosure.coefficients]
    far = sorted(np.roots(chi), key=abs)
    if r < 1e-9:
        near = far[: len(finite) - 1]
        assert np.allclose(np.poly(near).real, finite, atol=1e-4)
        for root in far[len(finite) - 1 :]:
            distance = float(locus.distance.subs(R_2, r))
            assert abs(abs(root) / distance - 1) < 0.01
        assert len(far) - len(near) == locus.number_to_infinity
    if r > 1e9 and "s**2" not in D:
        expected = [float(c) for c in locus.expensive.enclosure.coefficients]
        assert np.allclose(chi, expected, atol=1e-4)


@given(polynomials(max_degree=1), polynomials(min_degree=2, max_degree=2), st.integers(1, 9))
def test_closed_forms_are_the_certified_polynomials(N, D, weight):
    locus = ct.regulator_locus(N, D)
    try:
        result = locus.at(weight)
    except ct.CompensatorError:
        assume(False)
    for form, ball in zip(locus.closed_form, result.enclosure.coefficients, strict=True):
        assert abs(form.subs(R_2, weight).evalf(40) - ball.centre) < 1e-25


def test_refusals_name_what_is_wrong():
    one = [[1]]
    with pytest.raises(NoSolutionError, match="E_2 = 0"):
        ct.solve_riccati(one, one, E_1=one, E_2=[[0]], time="continuous")
    with pytest.raises(NotControllableError):
        ct.solve_riccati([[1, 0], [0, 1]], [[1], [1]], [[1, 0], [0, 0]], one, time="continuous")
    with pytest.raises(ct.InputError, match="discrete"):
        ct.solve_riccati(one, one, one, one, variable="z", time="continuous")
    with pytest.raises(NoSolutionError, match="singular"):
        ct.solve_riccati(one, [[1, 1]], E_1=one, E_2=[[1, 1]], time="continuous")
    with pytest.raises(ct.InputError, match="symmetric"):
        ct.solve_riccati([[1, 0], [0, 1]], [[1], [1]], Q=[[1, 2], [0, 1]], R=one, time="continuous")
    for both in ({"Q": one, "E_1": one}, {"R": one, "E_1": one}, {}, {"Q": one, "E_2": one}):
        with pytest.raises(ct.InputError, match=r"give the weights|goes with"):
            ct.solve_riccati(one, one, time="continuous", **both)
    with pytest.raises(NoSolutionError, match="no stabilising solution"):
        ct.solve_riccati(
            [[1, -1], [-1, 0]], [[-1, -1], [1, -1]], Q=[[0, -2], [-2, 0]], R=[[-1, 0], [0, 1]],
            time="continuous",
        )  # fmt: skip
    with pytest.raises(NoSolutionError, match="imaginary axis"):
        ct.solve_riccati([[0]], one, E_1=[[0], [0]], E_2=[[0], [1]], time="continuous")
    with pytest.raises(ct.InputError, match="StandardProblem"):
        ct.lqg_controller("1/s")
    with pytest.raises(ImproperError):
        ct.regulator_locus("s**2", "s + 1")
    with pytest.raises(ct.InputError):
        ct.regulator_locus("a", "x + 1", variable="x")
    with pytest.raises(ct.InputError):
        ct.spectral_factor("s", "1", -1, time="continuous")


def test_the_two_spectral_factors_agree_where_time_does_not_matter():
    """A constant has no dynamics, so that both factors are that constant's."""
    for variable, time in (("s", "continuous"), ("z", "discrete")):
        constant = ct.spectral_factor("3", variable=variable, time=time).constant
        assert (constant.centre, constant.radius) == (9, 0)


def test_a_limit_on_the_boundary_is_said():
    locus = ct.regulator_locus("s**2 + 1", "s*(s + 1)")
    assert str(locus).count("on the boundary of stability") == 2
    with pytest.raises(NoSolutionError):
        locus.at(0)
    assert locus.at(1).enclosure.degree == 2


def test_weights_have_the_places_that_lqr_gives_them():
    """`lqr(A, B, Q, R, N)` of other software; a signal z goes by name, and the error says so."""
    A, B = [[0, 1], [0, 0]], [[0], [1]]
    solution = ct.solve_riccati(A, B, [[1, 0], [0, 0]], [[1]], time="continuous")
    assert solution.P == ct.solve_riccati(A, B, Q=[[1, 0], [0, 0]], R=[[1]], time="continuous").P
    signal = {"E_1": [[1, 0], [0, 0]], "E_2": [[0], [1]]}
    assert solution.P == ct.solve_riccati(A, B, **signal, time="continuous").P
    for solve in (ct.solve_riccati, ct.regulator_spectrum, ct.riccati_formula):
        with pytest.raises(ct.InputError, match="Q = E_1'E_1"):
            solve(A, B, [[1, 0]], [[0]], time="discrete")
