"""Numbers, text and polynomials: the one way into the exact half."""
