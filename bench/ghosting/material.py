"""The load law of a sensor file (docs/formats.md, [material]), loads to conductances: for the truth alone."""

import numpy as np


def siemens_from_grams(loads_g, material):
    """Conductances of loads that are put on (frames × rows × columns): spread first, then each taxel's law."""
    felt = spread(loads_g, material.get("spread", (0.0, 0.0, 0.0)))
    if "saturation_load_g" in material:
        felt = felt / (1 + felt / material["saturation_load_g"])
    gain, exponent = (np.asarray(material.get(key, 1.0)) for key in ("gain", "exponent"))
    return material.get("g_zero_siemens", 0.0) + gain * material["factor"] * felt**exponent


def spread(loads_g, shares):
    """Each taxel gives shares of its load to its neighbours above and below, beside, and diagonal; beyond an edge they are lost."""
    row, column, diagonal = shares
    kept = 1 - 2 * (row + column) - 4 * diagonal
    felt = kept * np.asarray(loads_g, float)
    rows, columns = loads_g.shape[1:]
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            share = (0.0, column, row, diagonal)[2 * abs(down) + abs(right)]
            source = loads_g[:, _range(-down, rows), _range(-right, columns)]
            felt[:, _range(down, rows), _range(right, columns)] += share * source
    return felt


def _range(step, size):
    return slice(max(step, 0), size + min(step, 0))
