"""The structure theory of systems, exact: decompositions, zeros, fractions, realisations."""
