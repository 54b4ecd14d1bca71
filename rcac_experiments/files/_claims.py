"""The claims of an experiment file, and the checks that decide them."""

from __future__ import annotations

from typing import Any

from rcac_experiments.format._tables import Table
from rcac_experiments.format._values import Choice, MapOf, Numbers
from rcac_experiments.judging._claim import Check, Claim
from rcac_experiments.judging._measures import MEASURES, SIGNALS
from rcac_experiments.judging._reading import check_table, claim_table

# The standard claims of a case with a target model: the match, and the split of the residual.

STEPS = (1_000, 10_000, 100_000)  # at which the dissertation's figures and ours stop to look
NEAR = 0.1  # of the size of G_f, or of the power of the response to w
BETTER = 0.5  # of the distance at the first of the steps


def _at_steps(measure: str) -> tuple[Check, ...]:
    """The measure at each of the steps, the median over seeds; the run is that of the claim."""
    return tuple(
        Check(measure=measure, run="", until=k, statistic="median", at_most=NEAR) for k in STEPS
    )


STANDARD_CLAIMS = {
    "intercalated match": Claim(
        text="At steps 10^3, 10^4 and 10^5 the frequency response of the intercalated transfer "
        "function approximates that of the target model G_f: it is within 10 % of it at half of "
        "the frequencies.",
        checks=_at_steps("median_match"),
    ),
    "match improves": Claim(
        text="As RCAC adapts, the intercalated transfer function tends to G_f: at step 10^5 it is "
        "at most half as far from it as at step 10^3.",
        checks=(
            Check(
                measure="match_change",
                run="",
                until=STEPS[-1],
                statistic="median",
                at_most=BETTER,
                arguments={"since": STEPS[0]},
            ),
        ),
    ),
    "residual split": Claim(
        text="What RCAC's fit leaves over at steps 10^3, 10^4 and 10^5 is the response to w, which "
        "no controller takes away, and not the matching error, which has less than a tenth of its "
        "power.",
        checks=_at_steps("matching_error_share"),
    ),
}


FORMS = {"noise": MapOf(Numbers()), "signal": Choice(SIGNALS)}
CHECK: Table[Any] = check_table(
    {name: Table(function, supplied=["r"], forms=FORMS) for name, function in MEASURES.items()}
)
CLAIM: Table[Any] = claim_table(CHECK, tuple(STANDARD_CLAIMS))
