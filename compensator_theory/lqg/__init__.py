"""High-authority LQG: exact gains, Riccati solutions, costs, poles and target model."""
