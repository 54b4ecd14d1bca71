"""Theorem 1 as it is worded: signs, multiplicities, factors, hidden modes, several signals."""

from collections.abc import Iterator

from sympy import I, Matrix, Rational, Symbol, roots

from compensator_theory import (
    Realisation,
    observer_based_compensator,
    observer_forms,
    polynomial,
    realisation,
)
from compensator_theory.matrices._linear_algebra import characteristic_polynomial
from compensator_theory.observers import (
    is_lqg_suboptimal,
    pair_is_observer_based,
    transfer_function_is_observer_based,
)
from compensator_theory.roots import number_of_real_roots

Facts = Iterator[tuple[str, bool]]
s = Symbol("s")
SERVO = "1/(s**3 + s**2 + 2*s)"
SECOND_ORDER = Realisation([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])


def printed_sign() -> Facts:
    """N = 1, A = 0, K = F = 1, n = 1: with +K(sI - A_c)^-1F for G_c the loop has no real root."""
    design = observer_based_compensator("1/s", [1], [-1])
    G_c = design.transfer_function
    yield "K = 1 and F = 1", (design.K[0], design.F[0]) == (1, 1)
    with_plus = polynomial("s", "s") * G_c.denominator + G_c.numerator
    with_minus = polynomial("s", "s") * G_c.denominator - G_c.numerator
    yield "D D_c + N N_c with the printed sign is s^2 + 1", with_plus == polynomial("s**2 + 1")
    yield "with N_c = -K adj(sI - A_c) F it is s^2 - 1", with_minus == polynomial("s**2 - 1")


def example_7_1() -> Facts:
    """Example 7.1: the transfer function of (7.11), (7.12) is minus (7.31), and 8.26 is 8.25."""
    plant = Realisation([[-1, 4], [0, -3]], [[0], [1]], [[1, 0]])
    G_c = observer_based_compensator(plant, [-5, -4], [-2, -6]).transfer_function
    yield "D_c is s^2 + 13s + 49", G_c.denominator == polynomial("s**2 + 13*s + 49")
    yield "N_c is -(33/4 s + 93/4)", G_c.numerator == polynomial("-33*s/4 - 93/4")


def multiplicity() -> Facts:
    """A = 0, K = -1, F = 1, n = 1: observer-based with (s + 1)^2, one distinct root."""
    design = observer_based_compensator("1/s", [-1], [-1])
    yield "K = -1 and F = 1", (design.K[0], design.F[0]) == (-1, 1)
    loop = design.characteristic_polynomial
    yield "the closed-loop polynomial is (s + 1)^2", loop == polynomial("(s + 1)**2")
    yield "it has one distinct real root", loop.count_roots() == 1
    yield "and two with multiplicity", number_of_real_roots(loop) == 2


def distinct_roots() -> Facts:
    """n = 3, (s + 1)^2 (s^2 + 1)^2: a count of distinct real roots gives 1, and a form exists."""
    p = polynomial("(s + 1)**2*(s**2 + 1)**2")
    yield "SymPy counts one distinct real root", p.count_roots() == 1
    yield "with multiplicity there are two", number_of_real_roots(p) == 2
    design = observer_based_compensator(SERVO, [-1, I, -I], [-1, I, -I])
    yield "gains exist", design.characteristic_polynomial == p


def common_factors() -> Facts:
    """(a) n = 3, G = 1/(s^3 + s^2 + 2s), G_c = 2/(s + 1): with the factor g = (s + 3)(s + 4) the
    pair is observer-based, with g = s^2 + 4s + 5 it is not.
    """
    answers = []
    for factor in ("(s + 3)*(s + 4)", "(s**2 + 4*s + 5)"):
        pair = (f"2*{factor}", f"(s + 1)*{factor}")
        answers.append(pair_is_observer_based(SERVO, pair, feedback=-1).answer)
    yield "the pair with two real hidden roots is observer-based", answers[0] is True
    yield "the pair with a complex pair of hidden roots is not", answers[1] is False
    same = transfer_function_is_observer_based(SERVO, "2/(s + 1)", feedback=-1)
    yield "the transfer function, the same for both, is", same.answer is True


def disconnected() -> Facts:
    """(b1) n = 2: A = diag(3, 4), A_c = diag(1, 2), B_c = 0, C_c = 0 is in no basis an observer."""
    plant = Realisation([[3, 0], [0, 4]], [[1], [1]], [[1, 1]])
    forms = observer_forms(plant, Realisation([[1, 0], [0, 2]], [[0], [0]], [[0, 0]]))
    yield "the plant is minimal and n is even", plant.is_minimal is True
    yield "all 6 shares of the poles fail", len(forms.rejections) == 6 and not forms.forms
    yield "there are no others", forms.is_complete is True


def hidden_mode() -> Facts:
    """(b2) n = 2: A_c = diag(-6, -7), B_c = [1; 0], C_c = [12, 0], so that N_c is not 0."""
    hidden = Realisation([[-6, 0], [0, -7]], [[1], [0]], [[12, 0]])
    forms = observer_forms(SECOND_ORDER, hidden)
    spectrum = sorted(roots(forms.characteristic_polynomial))
    yield "the closed-loop spectrum is {-7, -5, -4, 0}", spectrum == [-7, -5, -4, 0]
    yield "all 6 shares fail", len(forms.rejections) == 6 and not forms.forms
    twice = Realisation([[-6, 0], [0, -5]], [[1], [0]], [[12, 0]])
    family = observer_forms(SECOND_ORDER, twice)
    yield "with -5 for -7 there is a continuum of forms", bool(family.has_continuum)


def real_roots_and_no_form() -> Facts:
    """(b3) n = 3: 2(s + 3)(s + 4)/((s + 1)(s + 3)(s + 4)) in controllable and observable form."""
    for form in ("controllable", "observable"):
        hidden = realisation("-2*(s + 3)*(s + 4)/((s + 1)*(s + 3)*(s + 4))", form=form)
        result = observer_forms(SERVO, hidden)
        real = number_of_real_roots(result.characteristic_polynomial)
        yield f"{form} form: two real roots", real == 2
        yield f"{form} form: all 4 shares fail", len(result.rejections) == 4 and not result.forms
    mixed = Realisation([[-1, 0, 0], [0, -3, 0], [0, 0, -4]], [[1], [1], [0]], [[-2, 0, 1]])
    forms = observer_forms(SERVO, mixed).forms
    shares = all(f.regulator.eval(-4) == 0 == f.observer.eval(-3) for f in forms)
    yield (
        "with -3 unobservable and -4 uncontrollable there are exactly 2",
        len(forms) == 2 and shares,
    )


def several_signals() -> Facts:
    """(c) two inputs and outputs, n = 2: minimal, and neither invariant plane gives a form."""
    half, one = Rational(1, 2), Matrix.eye(2)
    plant = Realisation([[-1, -half], [1, -half]], one, one)
    compensator = Realisation(
        [[0, -half], [1, -half]], [[0, -half], [-1, half]], [[0, half], [1, half]]
    )
    forms = observer_forms(plant, compensator)
    loop = polynomial("(s**2 + 1)*(s**2 + 2*s + 2)")
    yield "both are minimal", plant.is_minimal is True and compensator.is_minimal is True
    yield "D~ is (s^2 + 1)(s^2 + 2s + 2)", forms.characteristic_polynomial == loop
    yield "both real planes fail", len(forms.rejections) == 2 and not forms.forms


def suboptimality() -> Facts:
    """Section 7.6: 4/(s + 1) times g/g, g = s^2 + 4s + 5, on 1/(s^3 + 3s^2 + 8s + 6): the pair is
    not observer-based, and its transfer function is the optimum of an LQG problem.
    """
    plant, g = "1/(s**3 + 3*s**2 + 8*s + 6)", "(s**2 + 4*s + 5)"
    regulator, observer = [-2, -1 + I, -1 - I], [-3, -1 + 2 * I, -1 - 2 * I]
    design = observer_based_compensator(plant, regulator, observer).transfer_function.reduced()
    compensator = (-design.numerator, design.denominator)  # negative feedback
    pair = (f"4*{g}", f"(s + 1)*{g}")
    decided = pair_is_observer_based(plant, pair, feedback=-1)
    yield "the pair is not observer-based", decided.answer is False
    yield (
        "K and F with stable A + BK and A - FC, optimal for |u - Kx|^2 with the noises Fw and w, "
        "give 4/(s + 1)",
        compensator == (polynomial("4", "s"), polynomial("s + 1")),
    )
    yield "it is not suboptimal", is_lqg_suboptimal(plant, pair, feedback=-1).answer is False


def printed_similarity() -> Facts:
    """(7.25) with S_C as (7.26) defines it: A + BK = S^-1 (A_C + B_C K_C) S, not S (...) S^-1."""
    A, B = Matrix([[-1, 4], [0, -3]]), Matrix([0, 1])
    K = Matrix([[-3, -5]])
    alpha = characteristic_polynomial(A, s).all_coeffs()
    A_C, B_C = Matrix([[0, 1], [-alpha[2], -alpha[1]]]), Matrix([0, 1])
    S = Matrix.hstack(B_C, A_C * B_C) * Matrix.hstack(B, A * B).inv()
    yield "S A = A_C S and S B = B_C", S * A == A_C * S and S * B == B_C
    inner = A_C + B_C * K * S.inv()
    yield "S^-1 (A_C + B_C K_C) S is A + BK", S.inv() * inner * S == A + B * K
    yield "S (A_C + B_C K_C) S^-1, as printed, is not", S * inner * S.inv() != A + B * K
