"""The load law of a sensor file (docs/formats.md, [material]), loads to conductances: for the truth alone."""

import numpy as np


def siemens_from_grams(loads_g, material, period_s=None):
    """Conductances of loads that are put on (frames × rows × columns): spread first, then what the material remembers of the
    frames before, then each taxel's law."""
    felt = spread(loads_g, material.get("spread", (0.0, 0.0, 0.0)))
    if "dynamic" in material:
        felt = remember(felt, material["dynamic"], period_s)
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


def remember(loads_g, law, period_s):
    """Acting loads of frames that follow each other, from rest (docs/dynamic.md): x = F + Σ w·s + Σ h·q, with the lags
    τ·ds/dt = F − s, the load running straight from frame to frame, and the plays q = clamp(q, F − r, F + r)."""
    lags = list(zip(law.get("lag_weight", []), law.get("lag_secs", [])))
    plays = list(zip(law.get("play_weight", []), law.get("play_g", [])))
    shape = loads_g.shape[1:]
    s, q = [np.zeros(shape) for _ in lags], [np.zeros(shape) for _ in plays]
    before, acting = np.zeros(shape), np.empty(loads_g.shape)
    for k, load in enumerate(loads_g):
        step = period_s if k else law["period_secs"]
        for i, (_, tau) in enumerate(lags):
            # The ramp's own solution: s lags τ·slope behind the load, and what it was off by before fades.
            slope = (load - before) / step
            s[i] = load - tau * slope + (s[i] - before + tau * slope) * np.exp(-step / tau)
        for j, (_, reach) in enumerate(plays):
            q[j] = np.clip(q[j], load - reach, load + reach)
        acting[k] = load + sum(w * x for (w, _), x in zip(lags, s)) + sum(h * x for (h, _), x in zip(plays, q))
        before = load
    return acting


def _range(step, size):
    return slice(max(step, 0), size + min(step, 0))
