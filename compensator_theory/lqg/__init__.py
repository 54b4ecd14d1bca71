"""LQG with proof: gains, Riccati solutions, poles and targets, high authority included."""
