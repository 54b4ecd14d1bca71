"""Statements about two polynomials and their Sylvester matrices."""

from __future__ import annotations

from typing import Any

import compensator_theory as exact
from compensator_theory.matrices.exact_matrices import exact_matrix
from rcac_numeric.experiments.exact.placements import Found
from rcac_numeric.experiments.exact.system import Entry, ExactSystem


def sylvester_matrix(system: ExactSystem, equals: Entry, second: bool = False) -> Found:
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
    return Found(exact_matrix(equals, "equals") == M, f"M_{1 + second} = [{rows}]")


def sylvester_rank(system: ExactSystem, equals: int, second: bool = False) -> Found:
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
    return Found(rank == equals, f"rank M_{1 + second} = {rank} of {M.rows}")


def sylvester_determinant(system: ExactSystem, equals: Entry, second: bool = False) -> Found:
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
    return Found(bool(is_claimed), f"det M_{1 + second} = {determinant}")


def common_roots(system: ExactSystem, equals: int) -> Found:
    """The number of common roots, with multiplicity: from a gcd, without a Sylvester matrix.

    Parameters
    ----------
    equals : int
        The number that is claimed.
    """
    count = exact.number_of_common_roots(*system.polynomials)
    return Found(None if count is None else count == equals, f"{count} common roots")


def _matrix(system: ExactSystem, second: bool) -> Any:
    make = exact.sylvester_m2 if second else exact.sylvester_m1
    return make(*system.polynomials)
