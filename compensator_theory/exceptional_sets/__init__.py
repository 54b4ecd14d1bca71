"""What a symbolic answer becomes where its exceptional polynomials vanish."""
