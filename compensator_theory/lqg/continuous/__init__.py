"""LQG in continuous time: controllers, poles, Riccati equations, limits of high authority."""
