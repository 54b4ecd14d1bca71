"""Linear equations between polynomials and polynomial matrices, and bases of their null spaces."""
