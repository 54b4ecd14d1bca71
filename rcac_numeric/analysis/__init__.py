"""LQG, Riccati equations, margins and costs: the analysis of a fixed controller in float64."""
