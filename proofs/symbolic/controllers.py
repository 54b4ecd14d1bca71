"""Controllers of Chapters 2 and 6 as functions of the shift q; scalar signals, gains as letters."""

from sympy import cancel, symbols

q = symbols("q")


def pid() -> bool:
    """(2.58)-(2.62): K_P/q + K_I/(q(q - 1)) + K_D(1/q - 1/q^2) over the denominator q^2 (q - 1)."""
    K_P, K_I, K_D = symbols("K_P K_I K_D")
    terms = K_P / q + K_I / q / (q - 1) + K_D * (1 / q - 1 / q**2)
    numerator = K_P * q * (q - 1) + K_I * q + K_D * (q - 1) ** 2
    return bool(cancel(terms - numerator / (q**2 * (q - 1))) == 0)


def with_integrator(n_c: int) -> bool:
    """(6.4), (6.5): the controller has the denominator q^n_c (q - 1), whatever its gains."""
    Q, K_1 = symbols(f"Q_1:{n_c + 1}"), symbols("K_1")
    fir = sum(gain * q ** (n_c - i) for i, gain in enumerate(Q, start=1))
    integral = K_1 * q / (q - 1)  # g(k) = g(k - 1) + y(k)
    claimed = ((q - 1) * fir + K_1 * q ** (n_c + 1)) / (q**n_c * (q - 1))
    return bool(cancel(fir / q**n_c + integral - claimed) == 0)
