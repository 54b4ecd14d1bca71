"""From the settings of RCMR to a refinement at step 0 for the kernel."""

from __future__ import annotations

import numpy as np

from rcac_numeric.arrays.validation import instance_of
from rcac_numeric.engine.compiled.estimators import Refinement, make_refinement
from rcac_numeric.estimation.refinement.markov import reconstruction
from rcac_numeric.estimation.refinement.settings import RCMR
from rcac_numeric.estimation.refinement.subsystems import FIRSubsystem, RepeatedParameters


def compiled_refinement(settings: RCMR) -> Refinement:
    """The refinement at step 0 for the kernel."""
    instance_of(settings, "settings", RCMR)
    chosen, l_u = settings.delays.index(settings.d), settings.l_u
    rows = slice(chosen * l_u, (chosen + 1) * l_u)
    eigenvalues, V_d, W = reconstruction(settings.H, settings.R, rows)
    part = settings.subsystem
    A_j = D_j = np.zeros(0)
    n_c, strictly_proper = 0, False
    if isinstance(part, RepeatedParameters):
        A_j = part.A
        D_j = part.D if part.D.shape[2] else np.zeros((part.l_theta, settings.n, settings.l_w))
    elif isinstance(part, FIRSubsystem):
        n_c, strictly_proper = part.n_c, part.strictly_proper
    return make_refinement(
        sizes=[settings.n, settings.l_w, l_u, settings.l_y, int(settings.E_1.shape[0])],
        A=settings.A,
        D_1=settings.D_1,
        B=settings.B,
        C=settings.C,
        delays=settings.delays,
        stack=settings.stack,
        H=settings.H,
        R=settings.R,
        eigenvalues=eigenvalues,
        V_d=V_d,
        W=W,
        chosen=chosen,
        eta_bar=settings.eta_bar,
        forgetting=settings.lambda_,
        direct=settings.method == "direct",
        change=settings.method == "nearest",
        k_update=settings.k_update,
        E_1=settings.E_1,
        n_c=n_c,
        strictly_proper=strictly_proper,
        A_j=A_j,
        D_j=D_j,
        P_0=settings.beta,
        theta_0=settings.theta_0,
        x_0=settings.x_0,
    )
