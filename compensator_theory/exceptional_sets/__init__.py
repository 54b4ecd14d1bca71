"""Case analysis of a symbolic answer where its exceptional polynomials vanish."""
