"""The structure theory of systems, exact: decompositions, canonical forms, zeros, fractions."""
