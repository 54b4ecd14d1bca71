"""What the zero directions of a plant mean for target models, any sizes.

With y and z of any number, q^n_c G_zu (D_c - N_c G_yu)^-1 is the compact form of (4.16). R stands
for the value of the inverse at z0, where it has no pole.
"""

from .letters import letters, reduced

eta_T, G_zu, R, G_f, D_c, N_c, G_yu = letters("eta_T G_zu R G_f D_c N_c G_yu")


def zero_is_kept() -> bool:
    """If eta'G_zu(z0) = 0, then eta' z0^n_c G_zu(z0) R = 0: the factor on the right is any."""
    return bool(reduced(eta_T * G_zu * R, {eta_T * G_zu: 0}) == 0)


def matching_needs_a_singular_factor() -> bool:
    """If G_f (D_c - N_c G_yu) = z0^n_c G_zu at z0 and eta'G_zu(z0) = 0, then
    (eta'G_f)(D_c - N_c G_yu) = 0: where eta'G_f is not 0, z0 is a closed-loop pole.
    """
    matched = eta_T * (G_f * D_c - G_f * N_c * G_yu) - eta_T * G_zu
    left = reduced(matched, {eta_T * G_zu: 0})
    return bool(reduced(left - eta_T * G_f * (D_c - N_c * G_yu), {}) == 0)
