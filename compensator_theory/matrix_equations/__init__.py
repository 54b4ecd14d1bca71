"""Linear equations for matrices: Sylvester, Lyapunov, Stein, Gramians, the regulator equations."""
