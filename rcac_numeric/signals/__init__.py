"""Commands, disturbances, noise and recorded data."""
