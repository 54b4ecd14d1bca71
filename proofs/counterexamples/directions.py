"""Target models that look right and lose a transmission zero."""

from collections.abc import Iterator

from sympy import Matrix, Rational, Symbol, eye, zeros

from compensator_theory import StandardProblem, intercalated_transfer_matrix, transfer_matrix
from compensator_theory.loops import direction_residual

Facts = Iterator[tuple[str, bool]]
q = Symbol("q")
z0 = Rational(3, 2)
X = Matrix([[1, Rational(1, 2)], [Rational(1, 2), 1]])  # eigenvalues 3/2 and 1/2
ETA = [1, 1]


def _plant() -> StandardProblem:
    """The plant with y = z = q^-2 (q I - X) u."""
    A = zeros(2, 2).row_join(eye(2)).col_join(zeros(2, 4))
    B = eye(2).col_join(-X)
    C = eye(2).row_join(zeros(2, 2))
    return StandardProblem(A=A, B=B, D_1=B, C=C, E_1=C, D_0=None, D_2=None, E_2=None, E_0=None)


def delay_matched() -> Facts:
    """G = q^-2 (q I - X), X with the eigenvalue 3/2: G_f = q^-1 I is matched, by the controller
    D_c = q I - X, N_c = 0.
    """
    plant, D_c = _plant(), q * eye(2) - X
    yield "eta'G(z0) = 0", direction_residual(plant.G_zu, z0, ETA).is_zero_matrix
    matched = intercalated_transfer_matrix(plant, zeros(2, 2), D_c).as_matrix()
    gap = (matched - eye(2) / q).applyfunc(lambda entry: entry.cancel())
    yield "the intercalated transfer matrix is q^-1 I", gap.is_zero_matrix
    yield "eta'G_f(z0) is not 0", not (Matrix([ETA]) / z0).is_zero_matrix
    yield "the controller has a pole at z0", D_c.subs(q, z0).det() == 0


def other_direction() -> Facts:
    """The zero 3/2 in the first channel alone has another direction than (1, 1)."""
    one = transfer_matrix([["(q - 3/2)/q**2", 0], [0, "1/q"]], "q")
    yield "it has the zero", (one.as_matrix().subs(q, z0)).det() == 0
    yield "eta'G_f(z0) is not 0", not direction_residual(one, z0, ETA).is_zero_matrix


def input_direction() -> Facts:
    """G = diag(1/q, 1/(q - 1/2)) (q I - X)/q has the right null vector of q I - X, and with it the
    left numerator as target; the left null vector is another.
    """
    v = Matrix(ETA)
    numerator = (q * eye(2) - X) / q**2
    G = Matrix.diag(1 / q, 1 / (q - Rational(1, 2))) * (q * eye(2) - X) / q
    at, f = G.subs(q, z0), numerator.subs(q, z0)
    yield "G(z0) v = 0 and G_f(z0) v = 0", (at * v).is_zero_matrix and (f * v).is_zero_matrix
    eta = at.T.nullspace()[0]
    yield "eta'G_f(z0) is not 0", not (eta.T * f).is_zero_matrix
