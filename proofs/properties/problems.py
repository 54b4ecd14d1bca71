"""The servo problem as a standard problem, the sensitivity, and RCMR's rearranged inputs."""

from hypothesis import assume
from hypothesis import strategies as st
from sympy import Matrix, Rational, eye, zeros

from compensator_theory import TransferFunction, sensitivity_function, servo_problem
from compensator_theory.loops import compensator_from_sensitivity
from compensator_theory.strategies import matrices, plants_and_compensators

from ..ledger.checks import for_all


@for_all(A=matrices(2, 2), B=matrices(2, 1), D_1=matrices(2, 1), C=matrices(1, 2),
         D_0=matrices(1, 1),
         q=st.sampled_from([Rational(7, 3), Rational(-5, 4), Rational(11, 2)]))  # fmt: skip
def servo_maps(A: Matrix, B: Matrix, D_1: Matrix, C: Matrix, D_0: Matrix, q: Rational) -> bool:
    """(2.27): the maps of the servo problem at q are [I, -G_d, 0], -G_u, [I, -G_d, -I] and -G_u,
    the first for z = e_0.
    """
    regular = q * eye(2) - Matrix(A)
    assume(regular.det() != 0)
    plant = servo_problem(A=A, B=B, D_1=D_1, C=C, D_0=D_0, performance="true")
    parts = {name: Matrix(getattr(plant, name)) for name in ("B", "C", "D_1", "D_0", "D_2", "E_0",
                                                              "E_1", "E_2")}  # fmt: skip
    inverse = regular.inv()
    G_u, G_d = Matrix(C) * inverse * Matrix(B) + Matrix(D_0), Matrix(C) * inverse * Matrix(D_1)
    one = eye(1)

    def value(C: str, B: str, D: str) -> Matrix:
        return parts[C] * inverse * parts[B] + parts[D]

    return bool(
        value("E_1", "D_1", "E_0") == Matrix.hstack(one, -G_d, zeros(1, 1))
        and value("C", "D_1", "D_2") == Matrix.hstack(one, -G_d, -one)
        and value("E_1", "B", "E_2") == -G_u == value("C", "B", "D_0")
    )


@for_all(loop=plants_and_compensators())
def sensitivity_determines(loop: tuple[TransferFunction, TransferFunction]) -> bool:
    """(7.24) gives back the compensator of a loop from its sensitivity, in lowest terms."""
    plant, compensator = loop
    assume(plant.numerator != 0)
    S = sensitivity_function(plant, compensator, feedback=-1)
    reconstructed = compensator_from_sensitivity(plant, S, feedback=-1)
    return bool(
        reconstructed.numerator * compensator.denominator
        == compensator.numerator * reconstructed.denominator
    )


@for_all(H=matrices(2, 4), U=matrices(4, 1), order=st.permutations(range(4)), cut=st.integers(1, 3))
def partition(H: Matrix, U: Matrix, order: list[int], cut: int) -> bool:
    """(8.38): columns of H and components of U, rearranged alike and cut in two, give H U."""
    H, U = Matrix(H), Matrix(U)
    rest, others = order[:cut], order[cut:]
    parts = [H.extract([0, 1], part) * U.extract(part, [0]) for part in (rest, others)]
    return bool(parts[0] + parts[1] == H * U)
