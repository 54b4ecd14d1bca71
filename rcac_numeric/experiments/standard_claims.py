"""The claims that every case with a target model can make: what RCAC fits, and what explains it."""

from __future__ import annotations

from rcac_numeric.experiments.claims import Check, Claim

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
        claimed="approximates",
        checks=_at_steps("median_match"),
    ),
    "match improves": Claim(
        text="As RCAC adapts, the intercalated transfer function tends to G_f: at step 10^5 it is "
        "at most half as far from it as at step 10^3.",
        claimed="tends to, end of section 4.4",
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
        claimed="the two parts of (4.14)",
        checks=_at_steps("matching_error_share"),
    ),
}
