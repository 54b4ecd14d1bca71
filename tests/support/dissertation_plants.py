"""Plants of the dissertation that several tests use."""

import numpy as np

from rcac_numeric import Plant, servo_plant, standard_plant

PLANT_4_1 = Plant(  # (4.25)-(4.28)
    A=[
        [0.855, 1, 0, 0, 0],
        [-0.1715, 0.855, -0.4266, -0.3607, 0.4952],
        [0, 0, 0.5, -0.5072, 0.6964],
        [0, 0, 0, 0.6716, 1],
        [0, 0, 0, -0.4514, 0.6716],
    ],
    B=[[0], [0], [0], [0], [1]],
    D_1=[[-0.6269], [0.3985], [-0.3306], [0.4415], [0.3794]],
    C=[[0.7298, -0.3954, -0.3605, 0.4003, 0.1447]],
    E_1=[[0.1717, 0.3351, -0.5294, -0.4476, 0.6145]],
)
PLANT_4_2 = standard_plant(  # (4.29)
    "(q - 0.5)*(q**2 - 1.92*q + 1.44)/((q - 1)*(q - 0.9)*(q**2 - 1.62*q + 0.81))"
)
PLANT_4_3 = servo_plant(  # (4.30)
    "(q**2 - 1.7*q + 0.785)*(q**2 - 1.4*q + 0.85)"
    "/((q - 0.5)*(q**2 - 1.8*q + 0.97)*(q**2 - 1.4*q + 0.98))"
)
_A_4_4 = [  # (4.31), (4.32)
    [0.9, 1, 0, 0, 0],
    [0, 0.95, -0.1507, -0.1674, 0.5189],
    [0, 0, 0.65, 1, 0],
    [0, 0, -0.4225, 0.65, 0.434],
    [0, 0, 0, 0, 0.95],
]
_C_4_4 = [[0.1596, 0.3991, -0.2405, -0.2672, 0.8283]]
PLANT_4_4 = servo_plant(A=_A_4_4, B=np.eye(5)[:, [4]], C=_C_4_4, performance="true")
# d and v one and the same signal, as (4.31) and (4.33) say literally
PLANT_4_4_LITERAL = Plant(
    A=_A_4_4, B=np.eye(5)[:, [4]], D_1=np.eye(5)[:, [4]], C=_C_4_4, D_2=[[1.0]]
)
PLANT_6_1 = standard_plant("(q - 0.8)*(q - 1.1)/((q - 0.5)*(q**2 - 1.9*q + 1))")


def rescaled(plant, alpha):
    """The plant whose outputs y and z from the state are multiplied by alpha."""
    return Plant(
        A=plant.A, B=plant.B, D_1=plant.D_1, C=alpha * plant.C, D_2=plant.D_2,
        E_1=alpha * plant.E_1, E_0=plant.E_0, blocks=plant.blocks,
    )  # fmt: skip
