"""Linear plants in the dress of two Python functions."""

from rcac_numeric import FunctionPlant, Plant

TWO_STATES = Plant(
    A=[[0.5, 0.25], [-0.125, 0.75]], B=[[1.0], [0.5]], D_1=[[1.0], [0.0]], C=[[1.0, -0.5]],
)  # fmt: skip


def as_functions(plant):
    """The same linear plant as two Python functions."""
    return FunctionPlant(
        advance=lambda k, x, u, w: plant.A @ x + plant.B @ u + plant.D_1 @ w,
        output=lambda k, x, w: (plant.C @ x + plant.D_2 @ w, plant.E_1 @ x + plant.E_0 @ w),
        n=plant.n, l_u=plant.l_u, l_w=plant.l_w, l_y=plant.l_y, l_z=plant.l_z, blocks=plant.blocks,
    )  # fmt: skip
