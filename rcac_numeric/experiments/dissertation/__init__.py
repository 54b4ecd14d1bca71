"""The numbered examples as data: plant, signals, settings and claims, one TOML file each."""
