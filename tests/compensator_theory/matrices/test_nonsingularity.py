"""Determinants of surds that are not zero, against SymPy's determinant and numbers of 60 digits."""

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from sympy import I, Matrix, sqrt

from compensator_theory import InputError
from compensator_theory.errors import NoSolutionError
from compensator_theory.forms import _jordan as jordan
from compensator_theory.forms import jordan_form
from compensator_theory.matrices._nonsingularity import is_proven_nonsingular, surd_ball
from compensator_theory.strategies import rationals
from tests.support.structure_cases import fewer

PARTS = (1, sqrt(2), sqrt(3), I, I * sqrt(5), sqrt(6))


@st.composite
def surd_matrices(draw, is_singular):
    """Entries from Q(sqrt 2, sqrt 3, ...); singular ones repeat a row up to a factor."""
    n = draw(st.integers(1, 3))
    entry = st.builds(lambda x, y, p: x + y * p, rationals(), rationals(), st.sampled_from(PARTS))
    T = Matrix(n, n, [draw(entry) for _ in range(n * n)])
    if is_singular:
        factor = draw(st.sampled_from(PARTS))
        T[n - 1, :] = (factor * T[0, :]).applyfunc(sympy.expand) if n > 1 else Matrix([[0]])
    return T


@given(surd_matrices(is_singular=False))
def test_what_is_proved_is_what_sympy_finds(T):
    determinant = sympy.expand(T.det(method="berkowitz"))
    assert is_proven_nonsingular(T) == (determinant != 0)


@fewer(2)
@given(surd_matrices(is_singular=True))
def test_a_singular_matrix_is_never_proved(T):
    assert not is_proven_nonsingular(T)


@given(rationals(), rationals(), st.sampled_from(PARTS), st.sampled_from((-2, -1, 1, 3)))
def test_balls_hold_their_numbers(x, y, part, power):
    number = x + y * part
    if number == 0:
        return
    real, imag = (float(v) for v in (number**power).evalf(30).as_real_imag())
    ball = surd_ball(number**power)
    assert abs(complex(ball.mid()) - complex(real, imag)) <= 1e-12 * max(
        1, abs(complex(real, imag))
    )


def test_a_gap_below_double_precision_is_proved():
    close = sqrt(2) - sympy.Rational(int(sympy.floor(sqrt(2) * 10**60)), 10**60)
    assert is_proven_nonsingular(Matrix([[close, 0], [0, 1]]))


@pytest.mark.parametrize(
    "bad", [Matrix([[1, 2]]), Matrix([["a", sqrt(2)], [0, 1]]), Matrix([[sympy.pi]])]
)
def test_refusals(bad):
    with pytest.raises(InputError):
        is_proven_nonsingular(bad)


@pytest.mark.parametrize("over", ["rational", "real", "complex"])
def test_a_jordan_basis_that_is_singular_is_refused(monkeypatch, over):
    """Columns that are zero meet A T = T J, and are no basis: the certificate must see that."""
    A = [[0, 2, 0], [1, 0, 0], [0, 0, 3]]
    assert jordan_form(A, over=over).certificate.holds
    right = jordan.joined
    monkeypatch.setattr(jordan, "joined", lambda rows, parts: right(rows, parts) * 0)
    monkeypatch.setattr(jordan, "_generators", lambda a, part: [(a[:, 0], part.multiplicity)])
    with pytest.raises(NoSolutionError, match="det T not 0: FAILS; the basis is wrong"):
        jordan_form(A, over=over)
