"""How often conditions hold over the draws of a strategy."""

from hypothesis import HealthCheck, Phase, given, seed, settings

SEEDS, DRAWS = 40, 20


def shares(strategy, *conditions):
    """Return the share of draws of which each condition holds, over seeds that are always the same.

    The draws of one seed hang together (shares of 0.12 to 0.44 where the mean is 0.3), and those of
    `derandomize` hang on the words of the function that is run: so there are many short series.
    """
    counts, drawn = [0] * len(conditions), []

    def run(value):
        drawn.append(value)
        for k, condition in enumerate(conditions):
            counts[k] += bool(condition(value))

    for number in range(SEEDS):
        batch = settings(
            max_examples=DRAWS, database=None, deadline=None, phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )  # fmt: skip
        seed(number)(batch(given(strategy)(run)))()
    return [count / len(drawn) for count in counts]
