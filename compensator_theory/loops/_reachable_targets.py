"""Which target models the intercalated transfer function can equal, and with which poles."""

from __future__ import annotations

import sympy
from sympy import Poly

from compensator_theory.errors import InputError, NotReachableTargetError
from compensator_theory.polynomials._budget import ask, integer, repr_of
from compensator_theory.polynomials._carrying import carrying
from compensator_theory.polynomials._formatting import format_polynomial
from compensator_theory.polynomials._poly import canonical
from compensator_theory.systems._conversions import TransferFunctionLike, transfer_function
from compensator_theory.systems._standard_problems import StandardProblem


@carrying()
def target_characteristic_polynomial(
    plant: StandardProblem | tuple[Poly, int], n_c: int, target: TransferFunctionLike
) -> Poly:
    r"""Return the closed-loop polynomial for which the intercalated map equals a target model.

    .. math:: \frac{N_{zu}\,q^{n_c}}{\tilde D} = G_f = \frac{N_f}{D_f}
              \iff \tilde D = \frac{N_{zu}\,q^{n_c} D_f}{N_f}

    Parameters
    ----------
    plant : StandardProblem or pair (N_zu, n)
        Scalar u and z; n is the order of the plant.
    n_c : int
        Order of the compensator, at least 0.
    target : transfer function
        :math:`G_f`; common factors of its numerator and denominator do not matter.

    Returns
    -------
    sympy.Poly
        Monic, of degree :math:`n + n_c`. Place its roots to match the target exactly.

    Raises
    ------
    NotReachableTargetError
        If the relative degree or the leading coefficient of the target differs from those of
        :math:`G_{zu}`, or the target has a zero that :math:`N_{zu} q^{n_c}` lacks.
    InputError
        If u or z is not scalar, or :math:`N_{zu} = 0`.

    Notes
    -----
    Source: (4.18) solved for its denominator. For the pole-placement targets (4.38), (4.39) it is
    :math:`\bar N_{zu,s}\, q^{n_c - n_p + d_{zu} + n_u} D_p` with the monic factor of the zeros
    inside the unit circle.

    Examples
    --------
    >>> from compensator_theory import standard_problem
    >>> from compensator_theory.loops import target_characteristic_polynomial
    >>> plant = standard_problem("2*(q - 0.5)/((q - 1)*(q - 2))")
    >>> target_characteristic_polynomial(plant, 2, "2*q/(q**2 - 0.1)").as_expr()
    q**4 - q**3/2 - q**2/10 + q/20
    """
    N_zu, n = _scalar_numerator(plant)
    integer(n_c, "the order n_c", at_least=0)
    ask("degree", n + n_c, "the closed loop")
    G_f = transfer_function(target, N_zu.gen).reduced()
    reachable = N_zu * Poly(N_zu.gen**n_c, N_zu.gen)
    relative_degree = n - int(N_zu.degree())
    if G_f.numerator.is_zero:
        raise NotReachableTargetError("the target is 0, which no loop around this plant becomes")
    if G_f.relative_degree != relative_degree:
        raise NotReachableTargetError(
            f"the target {G_f} has relative degree {G_f.relative_degree}, but G_zu has "
            f"{relative_degree} for every compensator; give the target that relative degree"
        )
    if sympy.cancel(G_f.leading_coefficient - N_zu.LC()) != 0:
        raise NotReachableTargetError(
            f"the target {G_f} has leading coefficient {G_f.leading_coefficient}, but G_zu has "
            f"{N_zu.LC()} for every compensator; scale the target's numerator"
        )
    missing = canonical(G_f.numerator.quo(G_f.numerator.gcd(reachable)))
    if missing.degree() > 0:
        raise NotReachableTargetError(
            f"the target {G_f} has zeros at the roots of {format_polynomial(missing.monic())}, "
            f"which are not roots of N_zu q^n_c = {format_polynomial(reachable)}; keep only zeros "
            f"of G_zu and at most {n_c} zeros at 0"
        )
    return canonical((reachable * G_f.denominator).exquo(G_f.numerator))


def _scalar_numerator(plant: StandardProblem | tuple[Poly, int]) -> tuple[Poly, int]:
    if isinstance(plant, StandardProblem):
        N_zu, n = plant.numerator("zu"), plant.n
    elif isinstance(plant, tuple) and len(plant) == 2 and isinstance(plant[0], Poly):
        N_zu, n = plant
    else:
        raise InputError(f"{repr_of(plant)} is neither a StandardProblem nor a pair (N_zu, n)")
    if N_zu.is_zero:
        raise InputError("N_zu = 0: the control does not reach z, so no target can be matched")
    return canonical(N_zu), n
