"""Plants and compensators: transfer functions, realisations, standard problems."""
