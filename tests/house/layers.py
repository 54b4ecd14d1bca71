"""The folders of the packages, from the ground up."""

# A folder imports itself and what stands before a `<` to its left, late imports and those for type
# checking counted. Folders between commas stand side by side and do not know each other.
HOUSE = {
    "compensator_theory": """
        polynomials < matrices, exceptional_sets < bezout, roots < systems
        < forms, loops, strategies < responses, stability, placement < lqg, observers
        < certificates, teaching
    """,
    "rcac_numeric": """
        arrays < plants, signals < plants.gallery, targets < controllers < compiled
        < identification < engine < analysis, export < estimation, checks < designing
        < plots, reports
    """,
    "rcac_experiments": """
        format < judging < experiments < files < sweeps, explorer < tuning < plots < reports
        < dissertation < cli
    """,
}
FLOORS = {
    package: [[folder.strip() for folder in floor.split(",")] for floor in floors.split("<")]
    for package, floors in HOUSE.items()
}
LAYERS = {package: [one for floor in floors for one in floor] for package, floors in FLOORS.items()}
