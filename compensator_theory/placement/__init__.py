"""Where poles can be put: compensators, gains, factorisations, geometric control."""
