"""What shows each type of result of this package, beside `rcac_numeric.reports.displays`."""

PICTURES = {
    "rcac_experiments.experiments.experiment:Verification": (
        "rcac_experiments.plots.requested:plot_verification"
    ),
    "rcac_experiments.sweeps.statistics:SweepSummary": (
        "rcac_experiments.plots.sweep:plot_summary"
    ),
    "rcac_experiments.sweeps.tuning:Tuned": "rcac_experiments.plots.tuned:plot_tuned",
}
SHEETS = {
    "rcac_experiments.experiments.experiment:Verification": (
        "rcac_experiments.reports.verification:verification_sheet"
    ),
    "rcac_experiments.sweeps.overview:SweepOverview": (
        "rcac_experiments.reports.studies:sweep_sheet"
    ),
    "rcac_experiments.sweeps.replay:ReplayedRun": (
        "rcac_experiments.reports.studies:replay_sheet"
    ),
    "rcac_experiments.sweeps.tuning:Tuned": "rcac_experiments.reports.tuned:tuned_sheet",
}
SMALL_PICTURES = {
    "rcac_experiments.experiments.experiment:Verification": (
        "rcac_experiments.reports.single:page_figures"
    ),
}
