"""Many runs of one experiment: what varies, how it is run and kept, and what came out."""
