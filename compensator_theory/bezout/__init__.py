"""Two polynomials: Sylvester and Bezout matrices, resultants, common factors, identities."""
