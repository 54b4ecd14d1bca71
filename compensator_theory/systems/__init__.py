"""What plants and compensators are: transfer functions, realisations, standard problems."""
