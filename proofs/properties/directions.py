"""Zero directions of plants with two inputs and outputs, and of the loops around them."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import Matrix, Rational, Symbol, eye, zeros

from compensator_theory import StandardProblem, intercalated_transfer_matrix, zero_direction_target
from compensator_theory.loops import direction_residual
from compensator_theory.strategies import matrices

from ..ledger.checks import for_all

q = Symbol("q")
Case = tuple[StandardProblem, Rational, list[Rational], Matrix]
OUTSIDE = st.sampled_from([Rational(3, 2), Rational(-2), Rational(6, 5)])


@st.composite
def plants_with_a_zero(draw: st.DrawFn) -> Case:
    """Draw y = z = diag(1/(q^2 - a_i q - b_i)) (q I - X) H u, z0, its left direction, and H."""
    z0, H, V = draw(OUTSIDE), Matrix(draw(matrices(2, 2))), Matrix(draw(matrices(2, 2)))
    assume(H.det() != 0 and V.det() != 0)
    X = V.inv() * Matrix.diag(z0, draw(st.sampled_from([Rational(0), Rational(1, 2)]))) * V
    A, B, C, rest = zeros(4, 4), zeros(4, 2), zeros(2, 4), -X * H
    eta = []
    for i in range(2):
        a, b = (Rational(draw(st.integers(-2, 2)), 2) for _ in range(2))
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = Matrix([[a, 1], [b, 0]])
        B[2 * i, :], B[2 * i + 1, :], C[i, 2 * i] = H[i, :], rest[i, :], 1
        eta.append(V[0, i] * (z0**2 - a * z0 - b))
        assume(z0**2 - a * z0 - b != 0)
    return (
        StandardProblem(A=A, B=B, D_1=B, C=C, E_1=C, D_0=None, D_2=None, E_2=None, E_0=None),
        z0,
        eta,
        H,
    )


@for_all(case=plants_with_a_zero(), D_0=matrices(2, 2), N_0=matrices(2, 2))
def loops_keep_the_zero(case: Case, D_0: Matrix, N_0: Matrix) -> bool:
    """Eta' times the intercalated transfer matrix is 0 at z0, whatever the controller
    (q I + D_0)^-1 N_0, unless the loop has a pole there.
    """
    plant, z0, eta, _ = case
    G = intercalated_transfer_matrix(plant, Matrix(N_0), q * eye(2) + Matrix(D_0))
    assume(G.denominator.eval(z0) != 0)
    return bool(direction_residual(G, z0, eta).is_zero_matrix)


@for_all(case=plants_with_a_zero())
def the_target_keeps_the_zero(case: Case) -> bool:
    """The target model built from (z0, eta) has the zero of the plant in its direction, and its
    leading coefficient.
    """
    plant, z0, eta, H = case
    built = zero_direction_target(H.tolist(), [(z0, eta)])
    leading = Matrix(2, 2, lambda i, j: built.transfer_matrix.numerators[i][j].nth(1))
    return bool(
        direction_residual(plant.G_zu, z0, eta).is_zero_matrix
        and direction_residual(built.transfer_matrix, z0, eta).is_zero_matrix
        and leading == H
    )
