"""The map that all sample files hold: 24 x 17 pixels with holes, from a formula."""

import numpy as np

NX, NY = 24, 17
PITCH_X, PITCH_Y = 5e-6, 4e-6


def heights(holes=True):
    """Heights [m], shape [NY, NX], y rising with the row, NaN in holes."""
    j, i = np.mgrid[0:NY, 0:NX].astype(float)
    z = 1e-6 * (0.3 * i + 0.5 * j + 2.0 * np.sin(0.7 * i) + np.cos(0.9 * j) + 0.02 * i * j)
    if holes:
        z[(7 * i + 11 * j) % 37 == 0] = np.nan
    return z
