"""Exact LQG, Riccati, Lyapunov and Sylvester equations and Gramians, in both time domains."""
