"""Whether a stable compensator can stabilise a plant, and where the poles lie if none can."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import flint
from sympy import Poly, Symbol

from compensator_theory._latex import displayed, words
from compensator_theory.errors import InputError
from compensator_theory.forms._smith_mcmillan import smith_mcmillan_form
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import canonical
from compensator_theory.polynomials._values import ExactValue
from compensator_theory.polynomials._variables import time_of
from compensator_theory.roots._certified import decided_balls
from compensator_theory.roots._counts import count_roots, require_rational
from compensator_theory.roots._enclosures import Enclosure, enclosure_of_ball
from compensator_theory.systems._conversions import transfer_function
from compensator_theory.systems._descriptions import has_states, shape_of
from compensator_theory.systems._matrix_conversions import TransferMatrixLike, transfer_matrix
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix


@dataclass(frozen=True)
class UnstableRealZero(ExactValue):
    """A real blocking zero outside the region of stability, and the sign of D there.

    Attributes
    ----------
    place : Enclosure or None
        Between two rational numbers; None for the zero at infinity of a strictly proper plant.
    sign : {+1, -1}
        Of the monic pole polynomial D(s); in discrete time, of D(z)/z**n.

    Examples
    --------
    >>> from compensator_theory import decide_strong_stabilisability
    >>> [zero.sign for zero in decide_strong_stabilisability("(s - 1)/(s*(s - 2))").zeros]
    [-1, 1]
    """

    place: Enclosure | None
    sign: int

    def __str__(self) -> str:
        return "infinity" if self.place is None else f"{float(self.place):.6g}"

    def _repr_latex_(self) -> str:
        place = r"\infty" if self.place is None else f"{float(self.place):.6g}"
        return displayed(rf"\operatorname{{sgn}} D\left({place}\right) = {self.sign}")


@dataclass(frozen=True)
class StrongStabilisability(ExactValue):
    """The answer with its evidence: the real unstable zeros in their order, with the signs of D.

    Attributes
    ----------
    plant : str
    zeros : tuple of UnstableRealZero
        Along the real axis outside the region of stability: from 0 to infinity, or from 1 through
        infinity to -1.
    is_stabilisable : bool
        False where a hidden mode is unstable.

    Examples
    --------
    >>> from compensator_theory import decide_strong_stabilisability
    >>> print(decide_strong_stabilisability("(z - 6/5)/((z - 3/2)*(z - 1/2))"))
    (z - 6/5)/(z**2 - 2*z + 3/4) is not strongly stabilisable: every compensator that stabilises it
    has a real pole between the zeros 1.2 and infinity
    """

    _ANSWER = "is_strongly_stabilisable"

    plant: str
    zeros: tuple[UnstableRealZero, ...]
    is_stabilisable: bool

    @property
    def is_strongly_stabilisable(self) -> bool:
        """Whether a stable proper compensator stabilises the plant."""
        return self.is_stabilisable and not self.pole_intervals

    @property
    def pole_intervals(self) -> tuple[tuple[UnstableRealZero, UnstableRealZero], ...]:
        """Neighbouring zeros between which every stabilising compensator has a real pole."""
        return tuple((a, b) for a, b in pairwise(self.zeros) if a.sign != b.sign)

    def __str__(self) -> str:
        if not self.is_stabilisable:
            return f"{self.plant} is not stabilisable: it has an unstable hidden mode"
        if self.is_strongly_stabilisable:
            return f"{self.plant} is strongly stabilisable: a stable compensator stabilises it"
        places = ", and ".join(f"between the zeros {a} and {b}" for a, b in self.pole_intervals)
        return (
            f"{self.plant} is not strongly stabilisable: every compensator that stabilises it\n"
            f"has a real pole {places}"
        )

    def _repr_latex_(self) -> str:
        return displayed(words(str(self)))


@refusing
def decide_strong_stabilisability(
    plant: TransferMatrixLike, variable: str | Symbol | None = None
) -> StrongStabilisability:
    r"""Decide whether a stable compensator can stabilise a plant, by parity interlacing.

    .. math:: \tilde D(z_i) = D(z_i) D_c(z_i) \quad\text{at every zero } z_i,\text{ for } f = \pm 1

    :math:`\tilde D` keeps its sign along the real axis outside the region of stability. Between
    neighbouring real unstable zeros at which D has different signs so has :math:`D_c`, and the
    compensator has a pole there: an unstable one. Where D has one sign at all of them, a stable
    compensator exists. With several signals D is the pole polynomial, of the McMillan degree, and
    the zeros are the blocking zeros, where the whole matrix vanishes.

    Parameters
    ----------
    plant : transfer function or transfer matrix
        Proper, rational coefficients; in s, or in z or q. Anything :func:`transfer_function` or
        :func:`transfer_matrix` reads. Of several signals a :class:`Realisation` shows every hidden
        mode, a common denominator only those that are no poles.
    variable : str or Symbol, optional
        Of the plant; default: evident.

    Returns
    -------
    StrongStabilisability
        Exact: signs at algebraic numbers are decided in certified balls.

    Raises
    ------
    InputError
        If the plant is zero, improper, symbolic, or its variable is none of s, z and q.

    Notes
    -----
    An adaptive controller that stabilises such a plant ends with this unstable pole; one whose
    poles are fixed inside, FIR for instance, cannot stabilise it. Source: D. C. Youla, J. J.
    Bongiorno, C. N. Lu, Automatica 10 (1974) 159-173; M. Vidyasagar, Control System Synthesis,
    5.3.

    Examples
    --------
    >>> from compensator_theory import decide_strong_stabilisability
    >>> decide_strong_stabilisability("(s - 2)/(s**2 - 1)").is_strongly_stabilisable
    True
    >>> P = "(s - 1)/(s*(s - 2))"  # one pole between 1 and infinity; of two such plants, two
    >>> decide_strong_stabilisability([[P, 0], [0, P]]).is_strongly_stabilisable
    True
    """
    G, N, D, hidden, vanishes_at_infinity = interlacing(plant, variable)
    time = time_of(G.variable, "strong stabilisability")
    discrete = time == "discrete"
    modes = count_roots(hidden, time=time)
    right = _zeros(N, D, 1 if discrete else 0, discrete)
    left = _zeros(N, D, -1, discrete) if discrete else []
    infinity = [UnstableRealZero(None, 1)] if vanishes_at_infinity else []
    return StrongStabilisability(str(G), (*right, *infinity, *left), modes.stable == modes.total)


def _zeros(N: Poly, D: Poly, edge: int, discrete: bool) -> list[UnstableRealZero]:
    """Return the real zeros from the edge outwards to infinity, or from -infinity to -1."""
    outwards = 1 if edge >= 0 else -1
    coefficients = [flint.fmpq(int(c.p), int(c.q)) for c in reversed(D.all_coeffs())]
    size = len(coefficients) - 1

    def decide(ball: flint.acb) -> int | None:
        """0 for a zero elsewhere; else the sign of D; None where the ball is too large."""
        if ball.imag != 0:
            return 0
        place = ball.real
        if outwards * (place - edge) < 0:
            return 0
        is_edge = edge == place  # a rational root has a ball of radius 0, or one that shrinks to it
        if not is_edge and not outwards * (place - edge) > 0 and N.eval(edge) != 0:
            return None
        value = flint.arb(0)
        for c in reversed(coefficients):
            value = value * place + c
        if discrete and outwards < 0 and size % 2:
            value = -value
        return 1 if value > 0 else -1 if value < 0 else None

    zeros = [(enclosure_of_ball(b.real), s) for b, _, s in decided_balls(N, decide) if s]
    zeros.sort(key=lambda item: item[0].lower)
    return [UnstableRealZero(place, sign) for place, sign in zeros]


# Data of parity interlacing for any number of signals: blocking zeros and poles.


class Interlacing(NamedTuple):
    """The polynomials whose real roots interlace.

    Attributes
    ----------
    plant : TransferFunction or TransferMatrix
    zeros : sympy.Poly
        Its roots are the finite blocking zeros: there the whole matrix vanishes.
    poles : sympy.Poly
        Monic, of the McMillan degree.
    hidden : sympy.Poly
        The modes that no transfer function shows.
    is_strictly_proper : bool
        Whether infinity is a blocking zero.
    """

    plant: TransferFunction | TransferMatrix
    zeros: Poly
    poles: Poly
    hidden: Poly
    is_strictly_proper: bool


def interlacing(plant: TransferMatrixLike, variable: str | Symbol | None = None) -> Interlacing:
    """Return the blocking zeros, poles and hidden modes of a plant."""
    G = _read(plant, variable)
    matrix = G if isinstance(G, TransferMatrix) else transfer_matrix(G)
    entries = [entry for entry in _entries(matrix) if not entry.numerator.is_zero]
    if not entries:
        raise InputError("the plant is 0, so that it has no zeros")
    for poly in (matrix.denominator, *(entry.numerator for entry in entries)):
        require_rational(poly)
    if not all(entry.is_proper for entry in entries):
        raise InputError(
            f"the plant {G} is improper; give a plant with at least as many poles as zeros"
        )
    reduced = [entry.reduced() for entry in entries]
    zeros = canonical(reduce(Poly.gcd, (entry.numerator for entry in reduced)))
    if matrix.shape == (1, 1):
        poles, knows_states = reduced[0].denominator, True
    else:
        poles, knows_states = (
            smith_mcmillan_form(matrix).pole_polynomial,
            has_states(plant, variable),
        )
    return Interlacing(
        G,
        zeros,
        poles,
        _hidden(matrix.denominator, poles, knows_states),
        all(entry.is_strictly_proper for entry in entries),
    )


def _read(
    plant: TransferMatrixLike, variable: str | Symbol | None
) -> TransferFunction | TransferMatrix:
    if shape_of(plant, variable) == (1, 1):
        return transfer_function(plant, variable)
    return transfer_matrix(plant, variable)


def _entries(matrix: TransferMatrix) -> list[TransferFunction]:
    outputs, inputs = matrix.shape
    return [matrix[i, j] for i in range(outputs) for j in range(inputs)]


def _hidden(denominator: Poly, poles: Poly, knows_states: bool) -> Poly:
    """Return det(sI - A)/poles; of a common denominator the factor without poles.

    A common denominator does not show the multiplicity of a pole among the states.
    """
    if knows_states:
        return canonical(denominator.exquo(poles))
    rest = denominator
    while (common := rest.gcd(poles)).degree() > 0:
        rest = rest.exquo(common)
    return canonical(rest)
