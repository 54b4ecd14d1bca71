"""The joint fit of theta and D_f, section 9.2.2, as operators that need not commute.

z^ = D_f z - N_f (u - Phi theta); for an IIR controller Phi theta = P u + Q y.
"""

from .letters import letters, reduced

D_f, N_f, P, Q, Q_0, u, y, z = letters("D_f N_f P Q Q_0 u y z")


def unseen_direction() -> bool:
    """With y = z the control Q_0 y more and the denominator D_f - N_f Q_0 leave z^ as it is."""
    before = D_f * z - N_f * (u - P * u - Q * y)
    after = (D_f - N_f * Q_0) * z - N_f * (u - P * u - (Q + Q_0) * y)
    return bool(reduced((after - before).subs(y, z), {}) == 0)
