"""One power law for the whole array, load = scale · (x − nothing)^power, fitted to the calibration presses alone."""

import numpy as np

POWERS = np.linspace(0.3, 3.0, 271)
FINER = np.linspace(-0.01, 0.01, 201)  # around the best of them


class PowerLaw:
    """x is a reading, or a conductance that somebody has freed of cross-talk."""

    def __init__(self, at_presses, loads_g, empty):
        """By the least sum of absolute errors in grams, which wrong labels can't carry away."""
        self.nothing = float(np.median(empty))
        above = np.asarray(at_presses, float) - self.nothing
        known = np.isfinite(above) & (above > 0) & (loads_g > 0)
        if known.sum() < 3:
            raise ValueError(f"{known.sum()} of {len(known)} presses read more than the empty array, 3 are needed")
        above, loads = above[known], np.asarray(loads_g)[known]
        self.unit = float(np.median(above))
        self.power = 0.0
        for powers in (POWERS, FINER):
            fits = [self._fit(above / self.unit, loads, self.power + power) for power in powers]
            _, self.power, self.scale = min(fits)

    @staticmethod
    def _fit(x, loads, power):
        basis = x**power
        scale = weighted_median(loads / basis, basis)
        return np.abs(scale * basis - loads).sum(), power, scale

    def grams(self, x):
        above = np.maximum(np.nan_to_num(np.asarray(x, float)) - self.nothing, 0.0)
        return self.scale * (above / self.unit) ** self.power


def weighted_median(values, weights):
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, total[-1] / 2)])
