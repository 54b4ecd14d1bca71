"""Certificates as records of JSON: matrices by name, and the equations that they satisfy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import sympy
from sympy import Expr, ImmutableMatrix, MatrixBase, Poly, Symbol
from sympy.polys.polyerrors import CoercionFailed

from compensator_theory._printing import decimal
from compensator_theory.bezout._common_factors import BezoutIdentity
from compensator_theory.errors import InputError
from compensator_theory.forms._equivalence import Equivalence
from compensator_theory.forms._matrix_equations import MatrixDiophantineSolution
from compensator_theory.forms._polynomial_equations import DiophantineSolution
from compensator_theory.forms._polynomial_matrices import PolynomialMatrix
from compensator_theory.lqg._riccati import RiccatiSolution
from compensator_theory.observers._design import ObserverBasedCompensator
from compensator_theory.observers._form import ObserverForm
from compensator_theory.placement._brunovsky import BrunovskyForm
from compensator_theory.placement._doubly_coprime import DoublyCoprimeFractions
from compensator_theory.placement._gain_families import StateFeedbackFamily
from compensator_theory.placement._matrix_placement import MatrixPlacement
from compensator_theory.placement._rounding_effects import is_stable
from compensator_theory.placement._solutions import PolePlacement
from compensator_theory.polynomials._budget import unlimited
from compensator_theory.polynomials._carrying import refusing
from compensator_theory.polynomials._poly import is_rational
from compensator_theory.polynomials._variables import Time, is_operator, time_of
from compensator_theory.responses._transition_matrices import TransitionMatrix
from compensator_theory.roots._number_fields import FieldMatrix
from compensator_theory.stability._stability_intervals import StabilityIntervals
from compensator_theory.systems._transfer_functions import TransferFunction
from compensator_theory.systems._transfer_matrices import TransferMatrix

FORMAT = 1
Record: TypeAlias = dict[str, Any]
Content: TypeAlias = (
    MatrixBase | Poly | Expr | PolynomialMatrix | TransferMatrix | TransferFunction | FieldMatrix
)
Product: TypeAlias = tuple[int, tuple[str, ...]]
"""A factor, and the names of matrices that are multiplied; a name with ' is transposed."""


class RecordWriter:
    """A record as it is written."""

    def __init__(self, kind: str, statement: str, variable: Symbol | None = None) -> None:
        self.kind, self.statement, self.variable = kind, statement, variable
        self.matrices: dict[str, MatrixBase] = {}
        self.generator: Symbol | None = None
        self.extension: Poly | None = None
        self.claims: dict[str, list[Any]] = {}

    def matrix(self, name: str, content: Content) -> None:
        """Add a matrix, or a polynomial as one of one entry."""
        if isinstance(content, FieldMatrix):
            minimal = content.field.minimal
            self.generator, self.extension = minimal.gen, minimal
            entries = [[p.as_expr() for p in row] for row in content.polynomials]
            content = ImmutableMatrix(entries)
            used = {s for e in content for s in e.free_symbols}
            content = content.xreplace(dict.fromkeys(used, minimal.gen))
        elif isinstance(content, PolynomialMatrix | TransferMatrix):
            content = content.as_matrix()
        elif isinstance(content, TransferFunction | Poly):
            content = ImmutableMatrix([[content.as_expr()]])
        elif isinstance(content, Expr):
            content = ImmutableMatrix([[content]])
        self.matrices[name] = content

    def equation(self, *terms: Product) -> None:
        """Claim that a sum of products vanishes."""
        self._claim("equations", [[str(c), list(names)] for c, names in terms])

    def spectrum(self, name: str, *terms: Product) -> None:
        """Claim that a sum of products has a characteristic polynomial."""
        self._claim("spectra", {"of": [[str(c), list(names)] for c, names in terms], "is": name})

    def regular(self, name: str) -> None:
        """Claim that a matrix is not singular."""
        self._claim("regular", name)

    def stable(self, name: str, time: Time) -> None:
        """Claim that a polynomial has stable roots only."""
        self._claim("stable", {"is": name, "time": time})

    def stable_if_so(self, name: str, polynomial: Poly) -> None:
        """Claim that a polynomial of rational numbers has stable roots only, where it does."""
        is_decided = is_operator(polynomial.gen) and is_rational(polynomial)
        if is_decided and is_stable(polynomial):
            self.stable(name, time_of(polynomial.gen, "stability"))

    def definite(self, name: str) -> None:
        """Claim that a symmetric matrix of numbers is positive definite."""
        self._claim("definite", name)

    def _claim(self, kind: str, claim: Any) -> None:
        self.claims.setdefault(kind, []).append(claim)

    def record(self) -> Record:
        """Return the record, with the symbols that it needs."""
        if not self.claims:
            raise InputError(f"the {self.kind} are empty, so there is nothing to record")
        used = {x for matrix in self.matrices.values() for e in matrix for x in e.free_symbols}
        used -= {self.variable, self.generator}
        ordered = [self.variable or Symbol("s"), *sorted(used, key=str)]
        if self.generator is not None:
            ordered.append(self.generator)
        record: Record = {"format": FORMAT, "kind": self.kind, "statement": self.statement}
        record["symbols"] = [symbol.name for symbol in ordered]
        record["extension"] = None if self.extension is None else _terms(self.extension, ordered)
        record["matrices"] = {k: _written(m, ordered) for k, m in self.matrices.items()}
        return record | self.claims


def _written(matrix: MatrixBase, symbols: Sequence[Symbol]) -> Record:
    """Write a matrix as numerators over one denominator."""
    fractions = [sympy.fraction(sympy.together(entry)) for entry in matrix]
    try:
        bottoms = [Poly(bottom, *symbols, domain="QQ") for _, bottom in fractions]
        common = Poly(1, *symbols, domain="QQ")
        for bottom in bottoms:
            common = common.lcm(bottom)
        tops = [
            Poly(top, *symbols, domain="QQ") * common.quo(bottom)
            for (top, _), bottom in zip(fractions, bottoms, strict=True)
        ]
    except (sympy.PolynomialError, CoercionFailed):
        raise InputError(
            "a record has rational functions of symbols; the result contains irrational numbers, "
            "so give rational data, or symbols in their place"
        ) from None
    return {
        "rows": matrix.rows,
        "columns": matrix.cols,
        "entries": [_terms(top, symbols) for top in tops],
        "over": _terms(common, symbols),
    }


def _terms(poly: Poly, symbols: Sequence[Symbol]) -> list[list[Any]]:
    """Write a polynomial as its terms."""
    read = (
        poly if tuple(poly.gens) == tuple(symbols) else Poly(poly.as_expr(), *symbols, domain="QQ")
    )
    return [[_number(c), [int(e) for e in powers]] for powers, c in read.terms() if c]


def _number(c: Expr) -> str:
    top, bottom = int(c.p), int(c.q)
    return decimal(top) if bottom == 1 else f"{decimal(top)}/{decimal(bottom)}"


def _placement(result: PolePlacement) -> RecordWriter:
    write = RecordWriter(
        "placement", "D D_c - f N N_c = lambda D~, D dD = f N dN", result.target.gen
    )
    plant = result.plant
    write.matrix("D", plant.denominator)
    write.matrix("N", plant.numerator)
    write.matrix("D_c", result.denominator)
    write.matrix("N_c", result.numerator)
    write.matrix("p", result.target)
    closed = plant.denominator.as_expr() * result.denominator.as_expr() - (
        result.feedback * plant.numerator.as_expr() * result.numerator.as_expr()
    )
    write.matrix("lambda", Poly(closed, result.target.gen).LC())
    write.equation((1, ("D", "D_c")), (-result.feedback, ("N", "N_c")), (-1, ("lambda", "p")))
    write.stable_if_so("p", result.target)
    for k, (above, below) in enumerate(result.homogeneous):
        write.matrix(f"dN{k}", above)
        write.matrix(f"dD{k}", below)
        write.equation((1, ("D", f"dD{k}")), (-result.feedback, ("N", f"dN{k}")))
    return write


def _diophantine(result: DiophantineSolution) -> RecordWriter:
    write = RecordWriter("Diophantine equation", "a x + b y = c, a dx + b dy = 0", result.a.gen)
    for name in ("a", "b", "c", "x", "y", "dx", "dy"):
        write.matrix(name, getattr(result, name))
    write.equation((1, ("a", "x")), (1, ("b", "y")), (-1, ("c",)))
    write.equation((1, ("a", "dx")), (1, ("b", "dy")))
    return write


def _bezout(result: BezoutIdentity) -> RecordWriter:
    write = RecordWriter("Bezout identity", "x a + y b = g, a = g a', b = g b'", result.a.gen)
    for name in ("a", "b", "x", "y"):
        write.matrix(name, getattr(result, name))
    write.matrix("g", result.gcd)
    write.matrix("a_g", result.quotients[0])
    write.matrix("b_g", result.quotients[1])
    write.equation((1, ("x", "a")), (1, ("y", "b")), (-1, ("g",)))
    write.equation((1, ("a",)), (-1, ("g", "a_g")))
    write.equation((1, ("b",)), (-1, ("g", "b_g")))
    return write


def _matrix_placement(result: MatrixPlacement) -> RecordWriter:
    write = RecordWriter("matrix placement", "D_l D_c - f N_l N_c = diag(p)", result.targets[0].gen)
    for name in ("D_l", "N_l", "D_c", "N_c"):
        write.matrix(name, getattr(result, name))
    write.matrix("p", ImmutableMatrix(sympy.diag(*(p.as_expr() for p in result.targets))))
    write.equation((1, ("D_l", "D_c")), (-result.feedback, ("N_l", "N_c")), (-1, ("p",)))
    return write


def _doubly_coprime(result: DoublyCoprimeFractions) -> RecordWriter:
    write = RecordWriter(
        "doubly coprime fractions",
        "[[V_l, -U_l], [-N_l, M_l]] [[M_r, U_r], [N_r, V_r]] = I",
        result.M_r.variable,
    )
    names = ("M_r", "N_r", "U_r", "V_r", "M_l", "N_l", "U_l", "V_l")
    for name in names:
        write.matrix(name, getattr(result, name))
    write.matrix("I_m", ImmutableMatrix.eye(result.M_r.shape[0]))
    write.matrix("I_p", ImmutableMatrix.eye(result.M_l.shape[0]))
    write.equation((1, ("V_l", "M_r")), (-1, ("U_l", "N_r")), (-1, ("I_m",)))
    write.equation((1, ("V_l", "U_r")), (-1, ("U_l", "V_r")))
    write.equation((1, ("M_l", "N_r")), (-1, ("N_l", "M_r")))
    write.equation((1, ("M_l", "V_r")), (-1, ("N_l", "U_r")), (-1, ("I_p",)))
    return write


def _equivalence(result: Equivalence) -> RecordWriter:
    write = RecordWriter("equivalence", "U P V = F, U U^-1 = I, V V^-1 = I", result.matrix.variable)
    for name, content in (
        ("P", result.matrix), ("F", result.form), ("U", result.U), ("V", result.V),
        ("U_inverse", result.U_inverse), ("V_inverse", result.V_inverse),
    ):  # fmt: skip
        write.matrix(name, content)
    write.equation((1, ("U", "P", "V")), (-1, ("F",)))
    for side in "UV":
        size = getattr(result, side).shape[0]
        write.matrix(f"I_{side}", ImmutableMatrix.eye(size))
        write.equation((1, (side, f"{side}_inverse")), (-1, (f"I_{side}",)))
    return write


def _matrix_diophantine(result: MatrixDiophantineSolution) -> RecordWriter:
    left = result.side == "right"
    statement = "A X + B Y = C" if left else "X A + Y B = C"
    write = RecordWriter("matrix Diophantine equation", statement, result.A.variable)
    for name in ("A", "B", "C", "X", "Y"):
        write.matrix(name, getattr(result, name))
    pairs = (("A", "X"), ("B", "Y")) if left else (("X", "A"), ("Y", "B"))
    write.equation(*((1, pair) for pair in pairs), (-1, ("C",)))
    return write


def _brunovsky(result: BrunovskyForm) -> RecordWriter:
    write = RecordWriter("Brunovsky form", "(A + B F) T = T A_c, B W = T B_c, T and W regular")
    for name in ("A", "B", "F", "T", "W", "A_c", "B_c"):
        write.matrix(name, getattr(result, name))
    write.equation((1, ("A", "T")), (1, ("B", "F", "T")), (-1, ("T", "A_c")))
    write.equation((1, ("B", "W")), (-1, ("T", "B_c")))
    write.regular("T")
    write.regular("W")
    return write


def _gain_family(result: StateFeedbackFamily) -> RecordWriter:
    write = RecordWriter("state feedback", "det(sI - A - B K) = p", result.polynomial.gen)
    for name, content in (("A", result.form.A), ("B", result.form.B), ("K", result.gain())):
        write.matrix(name, content)
    write.matrix("p", result.polynomial)
    write.spectrum("p", (1, ("A",)), (1, ("B", "K")))
    write.stable_if_so("p", result.polynomial)
    return write


def _observer_form(result: ObserverForm) -> RecordWriter:
    write = RecordWriter(
        "observer form", "B_c C + A_c T = T (A + B C_c T), both spectra", result.plant.variable
    )
    plant, compensator = result.plant, result.compensator
    for name, content in (
        ("A", plant.A), ("B", plant.B), ("C", plant.C), ("D", plant.D), ("A_c", compensator.A),
        ("B_c", compensator.B), ("C_c", compensator.C), ("T", result.T),
        ("p_R", result.regulator), ("p_O", result.observer),
    ):  # fmt: skip
        write.matrix(name, content)
    write.equation(
        (1, ("B_c", "C")), (1, ("A_c", "T")), (1, ("B_c", "D", "C_c", "T")),
        (-1, ("T", "A")), (-1, ("T", "B", "C_c", "T")),
    )  # fmt: skip
    write.spectrum("p_R", (1, ("A",)), (1, ("B", "C_c", "T")))
    write.spectrum("p_O", (1, ("A_c",)), (1, ("B_c", "D", "C_c")), (-1, ("T", "B", "C_c")))
    if result.T.rows == result.T.cols:
        write.regular("T")
    write.stable_if_so("p_R", result.regulator)
    write.stable_if_so("p_O", result.observer)
    return write


def _observer_based(result: ObserverBasedCompensator) -> RecordWriter:
    write = RecordWriter(
        "observer-based compensator", "det(sI - A - B K) = p_R, det(sI - A + F C) = p_O",
        result.plant.variable,
    )  # fmt: skip
    for name, content in (
        ("A", result.plant.A), ("B", result.plant.B), ("C", result.plant.C), ("K", result.K),
        ("F", result.F), ("p_R", result.regulator), ("p_O", result.observer),
    ):  # fmt: skip
        write.matrix(name, content)
    write.spectrum("p_R", (1, ("A",)), (1, ("B", "K")))
    write.spectrum("p_O", (1, ("A",)), (-1, ("F", "C")))
    write.stable_if_so("p_R", result.regulator)
    write.stable_if_so("p_O", result.observer)
    return write


def _riccati(result: RiccatiSolution) -> RecordWriter:
    if result.K_in_field is None or result.P_in_field is None:
        raise InputError(
            "the solution is known by enclosures alone, so that there is no identity to record; "
            "raise budget(field_degree=...)"
        )
    discrete = result.factor.time == "discrete"
    write = RecordWriter("Riccati equation", "the equation and its gain")
    for name in ("A", "B", "Q", "R", "N"):
        write.matrix(name, getattr(result, name))
    write.matrix("P", result.P_in_field)
    write.matrix("K", result.K_in_field)
    if discrete:  # (R + B'PB) K = -(B'PA + N'), P = A'PA + Q + (A'PB + N) K
        write.equation(
            (1, ("R", "K")), (1, ("B'", "P", "B", "K")), (1, ("B'", "P", "A")), (1, ("N'",))
        )
        write.equation(
            (1, ("P",)), (-1, ("A'", "P", "A")), (-1, ("Q",)), (-1, ("A'", "P", "B", "K")),
            (-1, ("N", "K")),
        )  # fmt: skip
    else:  # R K = -(B'P + N'), A'P + P A + Q + (P B + N) K = 0
        write.equation((1, ("R", "K")), (1, ("B'", "P")), (1, ("N'",)))
        write.equation(
            (1, ("A'", "P")), (1, ("P", "A")), (1, ("Q",)), (1, ("P", "B", "K")), (1, ("N", "K"))
        )
    write.equation((1, ("P",)), (-1, ("P'",)))
    return write


def _transition(result: TransitionMatrix) -> RecordWriter:
    write = RecordWriter("transition matrix", "(s I - A) Phi = I, or z I", result.variable)
    s, n = result.variable, result.A.rows
    discrete = result.responses[0][0].is_discrete
    write.matrix("A", result.A)
    write.matrix("s", s * ImmutableMatrix.eye(n))
    write.matrix("right", (s if discrete else 1) * ImmutableMatrix.eye(n))
    write.matrix("Phi", result.transform)
    write.equation((1, ("s", "Phi")), (-1, ("A", "Phi")), (-1, ("right",)))
    return write


def _intervals(result: StabilityIntervals) -> RecordWriter:
    write = RecordWriter(
        "stability intervals", "stable at a point of each interval", result.polynomial.gen
    )
    time = time_of(result.polynomial.gen, "stability")
    for k, cell in enumerate(result.intervals):
        value = result.polynomial.as_expr().subs(result.parameter, cell.sample)
        write.matrix(f"p{k}", Poly(value, result.polynomial.gen))
        write.stable(f"p{k}", time)
    return write


_WRITERS: dict[type, Callable[[Any], RecordWriter]] = {
    PolePlacement: _placement,
    DiophantineSolution: _diophantine,
    BezoutIdentity: _bezout,
    MatrixPlacement: _matrix_placement,
    DoublyCoprimeFractions: _doubly_coprime,
    Equivalence: _equivalence,
    MatrixDiophantineSolution: _matrix_diophantine,
    BrunovskyForm: _brunovsky,
    StateFeedbackFamily: _gain_family,
    ObserverForm: _observer_form,
    ObserverBasedCompensator: _observer_based,
    RiccatiSolution: _riccati,
    TransitionMatrix: _transition,
    StabilityIntervals: _intervals,
}


@refusing
def certificate_record(result: object) -> Record:
    r"""Return the certificate of a result as a record that another program can check.

    Parameters
    ----------
    result : PolePlacement, DiophantineSolution, RiccatiSolution, ObserverForm, ...
        A result whose data, given and computed, satisfy equations. The numeric half's
        ``CertifiedSet`` has a method of this name.

    Returns
    -------
    dict
        Strings, numbers and lists, for ``json.dump``: matrices of rational functions by name, and
        the equations, spectra and signs that they satisfy. ``proofs/recheck.py`` of a checkout
        checks a file of such records with Python's standard library alone, and documents the
        format.

    Raises
    ------
    InputError
        If the result is of another kind, or contains irrational numbers, except those of
        :class:`RiccatiSolution`, which are in one field.

    Examples
    --------
    >>> from compensator_theory import certificate_record, place_poles
    >>> record = certificate_record(place_poles("1/(s - 1)", [-1], feedback=-1))
    >>> record["statement"], record["symbols"], sorted(record["matrices"])
    ('D D_c - f N N_c = lambda D~, D dD = f N dN', ['s'], ['D', 'D_c', 'N', 'N_c', 'lambda', 'p'])
    """
    for kind, write in _WRITERS.items():
        if isinstance(result, kind):
            with unlimited():
                return write(result).record()
    kinds = ", ".join(kind.__name__ for kind in _WRITERS)
    raise InputError(f"a {type(result).__name__} has no certificate to record; these have: {kinds}")
