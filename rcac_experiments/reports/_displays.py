"""What shows each type of result of this package, beside `rcac_numeric.reports._displays`."""

PICTURES = {
    "rcac_experiments.experiments._experiment:Verification": (
        "rcac_experiments.plots._requested:plot_verification"
    ),
    "rcac_experiments.sweeps._statistics:SweepSummary": (
        "rcac_experiments.plots._sweep:plot_summary"
    ),
    "rcac_experiments.sweeps._tuning:Tuned": "rcac_experiments.plots._tuned:plot_tuned",
}
SHEETS = {
    "rcac_experiments.experiments._experiment:Verification": (
        "rcac_experiments.reports._verification:verification_sheet"
    ),
    "rcac_experiments.sweeps._overview:SweepOverview": (
        "rcac_experiments.reports._studies:sweep_sheet"
    ),
    "rcac_experiments.sweeps._replay:ReplayedRun": (
        "rcac_experiments.reports._studies:replay_sheet"
    ),
    "rcac_experiments.sweeps._tuning:Tuned": "rcac_experiments.reports._tuned:tuned_sheet",
}
SMALL_PICTURES = {
    "rcac_experiments.experiments._experiment:Verification": (
        "rcac_experiments.reports._single:page_figures"
    ),
}
