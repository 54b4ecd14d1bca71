"""Target models G_f: from modelling information, poles, Markov parameters, LQG."""
