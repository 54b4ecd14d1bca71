"""The linearised aircraft of Chapter 3, as its pairs (A, B)."""

from rcac_numeric import Plant

# (3.3), and (3.4) with its two wrong digits put right: 0.8482 and 0.8595 on the diagonal.
NOMINAL = (
    [
        [0.9553, 0.0265, -0.0934, 0.0039],
        [-2.5210, 0.9680, 0.1310, -0.0050],
        [0.0551, 0.0045, 0.9708, 0.0001],
        [-0.1282, 0.0989, -0.0369, 1.0004],
    ],
    [[0.0034], [0.2492], [-0.0017], [0.0126]],
)
OFF_NOMINAL = (
    [
        [0.8482, 0.0255, -0.0900, 0.0038],
        [-10.3212, 0.8595, 0.5152, -0.0210],
        [0.0186, 0.0041, 0.9723, 0.0001],
        [-0.5304, 0.0953, -0.0239, 0.9999],
    ],
    [[0.0036], [0.2390], [-0.0061], [0.0124]],
)


def aircraft(model, C):
    A, B = model
    return Plant(A=A, B=B, D_1=B, C=C)
