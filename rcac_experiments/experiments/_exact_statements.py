"""The statements of exact examples, their subjects, and their verdicts without a tolerance."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import attrs

import compensator_theory as exact
from compensator_theory.errors import CompensatorError, InputError
from compensator_theory.matrices._exact_matrices import exact_matrix
from compensator_theory.systems._conversions import transfer_function
from rcac_experiments.format._parts import PartialCall
from rcac_experiments.format._places import did_you_mean
from rcac_experiments.format._values import Exact, Sign
from rcac_numeric.arrays._values import Value

Entry = Annotated[Any, Exact()]


@attrs.frozen(eq=False, slots=False)
class ExactSystem(Value):
    """A plant, as matrices or as a transfer function, or two polynomials.

    Parameters
    ----------
    A, B, C : matrices, optional
        Of a plant, exact: numbers or strings such as "1/3".
    G : transfer function, optional
        Of a plant, where no matrices are given.
    feedback : {+1, -1}
        The sign of the loop: -1 from Section 7.3 on.
    a, b : polynomial, optional
        Of a Sylvester matrix.

    Examples
    --------
    >>> from rcac_experiments.experiments._exact_statements import ExactSystem
    >>> print(ExactSystem(A=[[-1, 4], [0, -3]], B=[[0], [1]], C=[[1, 0]]).transfer_function)
    (4)/(s**2 + 4*s + 3)
    """

    A: Entry = None
    B: Entry = None
    C: Entry = None
    G: Entry = None
    feedback: Annotated[int, Sign()] = -1
    a: Entry = None
    b: Entry = None

    @property
    def plant(self) -> exact.Realisation:
        """The plant as (A, B, C)."""
        if self.A is None or self.B is None or self.C is None:
            raise InputError("this statement is about A, B and C; [exact] needs all three.")
        return exact.Realisation(self.A, self.B, self.C)

    @property
    def transfer_function(self) -> exact.TransferFunction:
        """The plant as N/D, unreduced."""
        if self.G is not None:
            return transfer_function(self.G)
        return transfer_function(self.plant)

    @property
    def polynomials(self) -> tuple[Any, Any]:
        """Both polynomials, as given."""
        if self.a is None or self.b is None:
            raise InputError("this statement is about two polynomials; [exact] needs a and b.")
        return self.a, self.b


class Evaluation(NamedTuple):
    """Whether a statement holds (None: undecided), and the computed result."""

    holds: bool | None
    words: str


def regulator_gain(system: ExactSystem, poles: Entry, equals: Entry) -> Evaluation:
    """The gain K with the eigenvalues of A + BK, (7.27).

    Parameters
    ----------
    poles : numbers
        The requested eigenvalues.
    equals : matrix
        The gain that is claimed.
    """
    plant = system.plant
    K = exact.regulator_gain(plant.A, plant.B, poles)
    return Evaluation(exact_matrix(equals, "equals") == K, f"K = {_row(K)}")


def observer_gain(system: ExactSystem, poles: Entry, equals: Entry) -> Evaluation:
    """The gain F with the eigenvalues of A - FC, (7.30).

    Parameters
    ----------
    poles : numbers
        The requested eigenvalues.
    equals : matrix
        The gain that is claimed.
    """
    plant = system.plant
    F = exact.observer_gain(plant.A, plant.C, poles)
    return Evaluation(exact_matrix(equals, "equals") == F, f"F = {_row(F.T)}'")


def observer_based_compensator(
    system: ExactSystem, regulator: Entry, observer: Entry, equals: str
) -> Evaluation:
    """The pair (N_c, D_c) of the compensator (7.11), (7.12), with the sign of the loop.

    Parameters
    ----------
    regulator, observer : numbers
        The eigenvalues of A + BK and of A - FC.
    equals : str
        The transfer function that is claimed.
    """
    compensator = exact.observer_based_compensator(
        system.plant, regulator, observer
    ).transfer_function
    pair = exact.TransferFunction(compensator.numerator * system.feedback, compensator.denominator)
    return Evaluation(_same_pair(pair, transfer_function(equals)), f"G_c = {pair}")


def closed_loop(system: ExactSystem, compensator: str, polynomial: str) -> Evaluation:
    """The closed-loop polynomial of a pair, (7.23), common factors kept.

    Parameters
    ----------
    compensator : str
        The pair N_c/D_c.
    polynomial : str
        The closed-loop polynomial that is claimed.
    """
    G, G_c = system.transfer_function, transfer_function(compensator)
    loop = G.denominator * G_c.denominator - system.feedback * G.numerator * G_c.numerator
    return Evaluation(loop == exact.polynomial(polynomial), f"D~ = {loop.as_expr()}")


def placement(
    system: ExactSystem, poles: Entry, compensator: str, n_c: int | None = None, decimals: int = -1
) -> Evaluation:
    """The compensator that places poles, (7.37), and that there is no other with deg N_c < n.

    Parameters
    ----------
    poles : numbers
        The requested closed-loop poles.
    compensator : str
        The compensator that is claimed.
    n_c : int, optional
        Its order, where it is not the number of poles less n.
    decimals : int
        To how many decimals its coefficients are rounded; exact where it is left out.
    """
    placement = exact.place_poles(system.transfer_function, poles, n_c, feedback=system.feedback)
    claimed, words = transfer_function(compensator), f"G_c = {placement.compensator}"
    if decimals < 0:
        is_claimed = _same_pair(placement.compensator, claimed)
    else:
        is_claimed = _rounds_to(placement.compensator, claimed, decimals)
    if not placement.is_unique:
        return Evaluation(False, f"{words}, and others")
    return Evaluation(is_claimed, f"{words}, unique")


def no_unique_placement(
    system: ExactSystem, poles: Entry, n_c: int, numerator_degree: int
) -> Evaluation:
    """Several compensators of some degrees place the same poles.

    Parameters
    ----------
    poles : numbers
        The closed-loop poles.
    n_c, numerator_degree : int
        The order, and the largest degree of N_c.
    """
    placement = exact.place_poles(
        system.transfer_function,
        poles,
        n_c,
        feedback=system.feedback,
        numerator_degree=numerator_degree,
    )
    count = len(placement.homogeneous)
    return Evaluation(
        not placement.is_unique, f"a family with {count} free parameter{'s'[: count != 1]}"
    )


def observer_based(
    system: ExactSystem, compensator: str, answer: bool = True, forms: int = -1
) -> Evaluation:
    """Whether a pair is observer-based over the reals, Theorem 1.

    Parameters
    ----------
    compensator : str
        The pair N_c/D_c.
    answer : bool
        The claim.
    forms : int
        In how many forms; not looked at where it is left out.
    """
    decision = exact.observers.pair_is_observer_based(
        system.transfer_function, compensator, feedback=system.feedback
    )
    words = f"{decision.answer}: {decision.reason}"
    if decision.answer is None:
        return Evaluation(None, words)
    counted = forms < 0 or decision.number_of_forms == forms
    return Evaluation(decision.answer is answer and counted, words)


def placed_pair_is_observer_based(
    system: ExactSystem, poles: Entry, answer: bool = True
) -> Evaluation:
    """Whether the compensator of order n that places poles is observer-based over the reals.

    Parameters
    ----------
    poles : numbers
        The 2n closed-loop poles.
    answer : bool
        The claim.
    """
    placement = exact.place_poles(system.transfer_function, poles, feedback=system.feedback)
    decision = exact.observers.pair_is_observer_based(
        system.transfer_function, placement.compensator, feedback=system.feedback
    )
    is_claimed = None if decision.answer is None else decision.answer is answer
    return Evaluation(is_claimed, f"{decision.answer}: {decision.reason}")


def _row(matrix: Any) -> str:
    return f"[{', '.join(map(str, matrix))}]"


def _same_pair(a: exact.TransferFunction, b: exact.TransferFunction) -> bool:
    """Whether numerators and monic denominators are the same, common factors included."""
    return bool(a.numerator == b.numerator and a.denominator == b.denominator)


def _rounds_to(
    computed: exact.TransferFunction, claimed: exact.TransferFunction, decimals: int
) -> bool:
    """Whether every coefficient, rounded to so many decimals, is the claimed one."""
    half = Fraction(1, 2) / 10**decimals
    pairs = [
        (computed.numerator, claimed.numerator),
        (computed.denominator, claimed.denominator),
    ]
    for exactly, rounded in pairs:
        if exactly.degree() != rounded.degree():
            return False
        for difference in (exactly - rounded).all_coeffs():
            if abs(Fraction(int(difference.p), int(difference.q))) > half:
                return False
    return True


def sylvester_matrix(system: ExactSystem, equals: Entry, second: bool = False) -> Evaluation:
    """The Sylvester matrix M_1(a, b) of (B.1), or M_2(a, b) of (B.2).

    Parameters
    ----------
    equals : matrix
        The matrix that is claimed.
    second : bool
        Whether it is M_2.
    """
    M = _matrix(system, second)
    rows = "; ".join(" ".join(map(str, M.row(i))) for i in range(M.rows))
    return Evaluation(exact_matrix(equals, "equals") == M, f"M_{1 + second} = [{rows}]")


def sylvester_rank(system: ExactSystem, equals: int, second: bool = False) -> Evaluation:
    """The rank of M_1(a, b) or of M_2(a, b).

    Parameters
    ----------
    equals : int
        The rank that is claimed.
    second : bool
        Whether it is that of M_2.
    """
    M = _matrix(system, second)
    rank = int(M.rank())
    return Evaluation(rank == equals, f"rank M_{1 + second} = {rank} of {M.rows}")


def sylvester_determinant(system: ExactSystem, equals: Entry, second: bool = False) -> Evaluation:
    """The determinant of M_1(a, b) or of M_2(a, b).

    Parameters
    ----------
    equals : number
        The determinant that is claimed, exact.
    second : bool
        Whether it is that of M_2.
    """
    determinant = _matrix(system, second).det()
    is_claimed = determinant == exact.exact_number(equals)
    return Evaluation(bool(is_claimed), f"det M_{1 + second} = {determinant}")


def common_roots(system: ExactSystem, equals: int) -> Evaluation:
    """The number of common roots, with multiplicity: from a gcd, without a Sylvester matrix.

    Parameters
    ----------
    equals : int
        The number that is claimed.
    """
    count = exact.bezout.number_of_common_roots(*system.polynomials)
    return Evaluation(None if count is None else count == equals, f"{count} common roots")


def _matrix(system: ExactSystem, second: bool) -> Any:
    make = exact.bezout.sylvester_m2 if second else exact.bezout.sylvester_m1
    return make(*system.polynomials)


Statement = Callable[..., Evaluation]
STATEMENTS: dict[str, Statement] = {
    function.__name__: function
    for function in (
        regulator_gain,
        observer_gain,
        observer_based_compensator,
        closed_loop,
        placement,
        no_unique_placement,
        observer_based,
        placed_pair_is_observer_based,
        sylvester_matrix,
        sylvester_rank,
        sylvester_determinant,
        common_roots,
    )
}


@attrs.frozen(eq=False)
class ExactCheck(Value):
    """A statement that is decided exactly.

    Attributes
    ----------
    statement : str
        A name of `STATEMENTS`.
    system : ExactSystem
        The subject.
    arguments : mapping
        The keyword arguments of the statement.

    Examples
    --------
    >>> from rcac_experiments.experiments._exact_statements import ExactCheck
    >>> from rcac_experiments.experiments._exact_statements import ExactSystem
    >>> pair = ExactSystem(a="s + 1", b="(s + 1)*(s + 2)")
    >>> result = ExactCheck("common_roots", pair, {"equals": 1}).evaluate()
    >>> result.holds, str(result)
    (True, '1 common roots')
    """

    statement: Annotated[str, "What is stated."]
    system: ExactSystem = attrs.field(factory=ExactSystem)
    arguments: Mapping[str, Any] = attrs.field(factory=dict)

    def __attrs_post_init__(self) -> None:
        if isinstance(self.statement, PartialCall):  # as a file's table is read
            object.__setattr__(self, "arguments", self.statement.arguments)
            object.__setattr__(self, "statement", self.statement.make.__name__)
        if self.statement not in STATEMENTS:
            raise InputError(
                f"the statement {self.statement!r} is not known; known are {', '.join(STATEMENTS)}."
                f"{did_you_mean(self.statement, STATEMENTS)}"
            )
        try:
            inspect.signature(STATEMENTS[self.statement]).bind(self.system, **self.arguments)
        except TypeError as error:
            raise InputError(f"the statement {self.statement!r}: {error}.") from None

    @property
    def runs(self) -> tuple[str, ...]:
        """No run: a statement needs no simulation."""
        return ()

    def moved(self, moves: Mapping[str, str]) -> ExactCheck:
        """Return the statement itself, which has no run."""
        return self

    def evaluate(self, results: Mapping[str, object] | None = None) -> ExactResult:
        """Decide the statement, without results of runs."""
        try:
            result = STATEMENTS[self.statement](self.system, **self.arguments)
        except CompensatorError as error:
            raise type(error)(f"the statement {self.statement!r}: ", *error.args) from None
        return ExactResult(self, result.holds, result.words)


@dataclass(frozen=True, eq=False)
class ExactResult(Value):
    """The exact result, and whether it agrees with the claim.

    Attributes
    ----------
    check : ExactCheck
    holds : bool or None
        None where it is undecided.
    result : str
        In words.
    missing_reason : str
        Empty: an exact decision has an answer.
    """

    check: ExactCheck
    holds: bool | None
    result: str
    missing_reason: str = ""

    def __str__(self) -> str:
        return self.result
