"""Bezout matrices, subresultants and Sylvester null spaces: what two polynomials share."""
