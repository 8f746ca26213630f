"""A network beside the circuit: how near does each come to loads that neither has seen?

A multilayer perceptron of scikit-learn learns loads from counts on 1,200 frames of a 16 × 16 mat; the circuit learns nothing, it is
told the parts. Both are held against 300 frames of other seeds: blobs as it was trained on, and fingers as it was not.
"""

import numpy as np
from sklearn.neural_network import MLPRegressor

import taxel

SENSOR = "mat-16x16-cd4067"


def drawn(pattern: str, frames: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts and true loads, newtons."""
    simulation = taxel.simulate(SENSOR, pattern=pattern, frames=frames, seed=seed)
    return simulation.counts, simulation.loads


# %% Learn.
counts, loads = drawn("blobs", 1200, seed=1)
centre, scale = counts.mean(axis=0), counts.std() + 1e-9


def features(of: np.ndarray) -> np.ndarray:
    """A frame as the network sees it: a line of numbers about 1."""
    return ((of - centre) / scale).reshape(len(of), -1)


largest = loads.max()
network = MLPRegressor(hidden_layer_sizes=(128,), learning_rate_init=3e-3, max_iter=200, early_stopping=True, tol=5e-3, random_state=1)
network.fit(features(counts), (loads / largest).reshape(len(loads), -1))

# %% Compare, where something presses.
pipeline = taxel.Pipeline(SENSOR)
raw = taxel.Pipeline(SENSOR, method="raw")
print("mean error of loaded taxels, N       as read   network   circuit")
for pattern, seed in [("blobs", 2), ("fingers", 3)]:
    counts, loads = drawn(pattern, 300, seed)
    found = {
        "as read": raw.process(counts).loads,
        "network": largest * network.predict(features(counts)).reshape(loads.shape),
        "circuit": pipeline.process(counts).loads,
    }
    loaded = loads > 0.05
    off = {name: np.abs(found[name] - loads)[loaded].mean() for name in found}
    print(f"{pattern:30}" + "".join(f"{value:10.4f}" for value in off.values()))
    assert off["circuit"] < 0.3 * off["network"]
