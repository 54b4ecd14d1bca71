"""Chapter 2 as it is printed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from sympy import Symbol, symbols

import compensator_theory as exact
from rcac_experiments.dissertation._tables import example_table
from rcac_numeric.plants._problems import servo_plant, standard_plant
from rcac_numeric.targets._pole_placement import pole_placement_target

Facts = Iterator[tuple[str, bool]]


def servo_performance() -> Facts:
    """The direct terms of z = e_n = r - y_0 - v, in w = [r; d; v]."""
    r, d, v, y_0 = symbols("r d v y_0")
    e_n = r - (y_0 + v)
    direct = [e_n.expand().coeff(signal) for signal in (r, d, v)]
    yield "e_n has the direct terms [1, 0, -1] in [r; d; v]", direct == [1, 0, -1]
    yield "which are D_2 of (2.26) and not its E_0 = [1, 0, 0]", direct != [1, 0, 0]
    plant = servo_plant("1/(q - 0.5)")
    yield "E_0 = D_2 in the servo problem with z = e_n", np.array_equal(plant.E_0, plant.D_2)


def waiting_periods() -> Facts:
    """The orders n_f of G_f = (4.38), (4.39) compared with n_c in Examples 4.6 and 4.8."""
    servo = servo_plant("(q**2 - 1.4*q + 0.85)/((q - 1.05)*(q**2 - 1.6*q + 0.89))")
    standard = standard_plant("(q - 1.2)/((q - 1.1)*(q - 2))")
    first = pole_placement_target(servo, ["0.3", "0.4", "0.6", "0.1j", "-0.1j"])
    second = pole_placement_target(standard, ["0.1", "0.3", "0.5", "0.3j", "-0.3j"])
    yield "in Example 4.6 n_f = 5 is more than n_c = 4", first.n_f == 5
    yield "in Example 4.8 n_f = 5 is more than n_c = 3", second.n_f == 5


def mixed_variables() -> Facts:
    """The denominator of (2.66) in one letter and in two."""
    q, z = Symbol("q"), Symbol("z")
    denominator = exact.polynomial("q**2 - 1.9*q + 0.9925")
    roots = np.roots([float(c) for c in denominator.all_coeffs()])
    near = np.abs(np.sort_complex(roots) - [0.95 - 0.3j, 0.95 + 0.3j]).max() < 1e-12
    yield "q^2 - 1.9q + 0.9925 has the roots 0.95 +- 0.3j", near
    printed = q**2 - 1.9 * z + 0.9925
    yield "what is printed holds two letters", printed.free_symbols == {q, z}


def sign_of_the_dc_gain() -> Facts:
    """G(1) of (2.66) compared with its first Markov parameter."""
    G = exact.transfer_function("(q - 0.9)*(q - 1.1)/((q - 0.99)*(q**2 - 1.9*q + 0.9925))")
    dc = G.numerator.eval(1) / G.denominator.eval(1)
    yield "G(1) = -400/37, about -10.81", dc == exact.exact_number("-400/37")
    yield "the first Markov parameter is 1", G.numerator.LC() == 1


def direct_markov_parameter() -> Facts:
    """G_zu with a direct term compared with both sides of (2.51), exactly, at z = 2."""
    A, B, E_1, E_2 = [["1/2"]], [[1]], [[1]], [[3]]
    proper = exact.transfer_function(exact.Realisation(A, B, E_1))
    whole = exact.transfer_function(exact.Realisation(A, B, E_1, E_2))
    # H_0 + H_1/2 + H_2/4 + ... where H_0 = E_2 and H_i = E_1 A^(i-1) B = 2^(1-i)
    series = 3 + sum((exact.exact_number("1/2") ** (2 * i - 1) for i in range(1, 40)), 0)
    limit = 3 + exact.exact_number("2/3")
    yield "the sum with H_0 = E_2 tends to 11/3", abs(float(limit - series)) < 1e-20
    yield "E_1(zI - A)^-1 B + E_2 is 11/3", whole(2) == limit
    yield "E_1(zI - A)^-1 B, as it is printed, is 2/3", proper(2) == exact.exact_number("2/3")


def pid_labels() -> Facts:
    """The example that applies the PID controller, and the equations that it names."""
    source = str(example_table("2.5")["source"])
    yield "Example 2.5 applies (2.58) to (2.62), before its plant (2.63)", "(2.58)-(2.63)" in source
    quasi_fir = str(example_table("6.4")["controller"].get("structure", ""))
    yield "the integrator of Chapter 6 is of another structure than pid", "pid" not in quasi_fir
