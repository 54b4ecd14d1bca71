"""LQG with proof in both time domains: gains, Riccati solutions, poles, limits and targets."""
