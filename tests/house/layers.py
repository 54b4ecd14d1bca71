"""The folders of the two packages, in the order of their layers."""

# From the ground up: a folder imports itself and what stands above it in this list, late imports
# and those for type checking counted.
LAYERS = {
    "compensator_theory": [
        "polynomials",
        "matrices",
        "roots",
        "transfer_functions",
        "systems",
        "loops",
        "stabilisation",
        "lqg",
        "placement",
        "observers",
        "strategies",
    ],
    "rcac_numeric": [
        "arrays",
        "plants",
        "plants.gallery",
        "signals",
        "targets",
        "identification",
        "controllers.updates",
        "controllers",
        "engine.compiled",
        "engine",
        "engine.reference",
        "analysis",
        "margins",
        "h2",
        "experiments.format",
        "experiments",
        "experiments.dissertation",
        "experiments.files",
        "checks",
        "plots",
        "reports",
        "cli",
    ],
}
