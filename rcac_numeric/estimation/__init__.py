"""On-line estimation of states, parameters and subsystems (Chapter 8); nothing here smooths."""
