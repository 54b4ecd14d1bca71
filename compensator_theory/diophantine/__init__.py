"""Linear equations between polynomials and polynomial matrices."""
