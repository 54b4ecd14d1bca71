"""What the statements of an exact example are about."""

from __future__ import annotations

from typing import Annotated, Any

import attrs

import compensator_theory as exact
from compensator_theory.errors import InputError
from rcac_numeric.arrays.values import Value
from rcac_numeric.experiments.format.values import Exact, Sign

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
    >>> from rcac_numeric.experiments.exact.system import ExactSystem
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
            return exact.transfer_function(self.G)
        return exact.transfer_function(self.plant)

    @property
    def polynomials(self) -> tuple[Any, Any]:
        """Both polynomials, as given."""
        if self.a is None or self.b is None:
            raise InputError("this statement is about two polynomials; [exact] needs a and b.")
        return self.a, self.b
