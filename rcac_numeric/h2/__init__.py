"""LQG and H2 costs, on Riccati and Lyapunov equations whose solutions are checked."""
