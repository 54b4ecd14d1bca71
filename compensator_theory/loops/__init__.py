"""A plant and a compensator joined: closed-loop polynomials, maps and matrices, intercalation."""
