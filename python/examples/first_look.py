"""First look: frames of counts to newtons, with the cross-talk removed and an error on every number.

Here a virtual e-Cone stands in for a sensor; with your own, the first line is `recording = taxel.read("grip.mcap")`.
"""

import numpy as np

import taxel

# %% A hand of five finger tips on a sensor of 64 × 128 taxels.
grip = taxel.simulate("econe", pattern="fingers", frames=100, seed=1)

# %% Loads by the circuit, and as if there were no cross-talk.
result = taxel.Pipeline("econe").process(grip.counts, standard_errors=True)
raw = taxel.Pipeline("econe", method="raw").process(grip.counts)
print(result)

# %% How far off is either, where something presses?
loaded = grip.loads > 0.05
off = np.abs(result.loads - grip.loads)[loaded]
off_raw = np.abs(raw.loads - grip.loads)[loaded]
print(f"mean error of loaded taxels: {off_raw.mean():.3f} N as read, {off.mean():.4f} N with the cross-talk removed")
inside = off <= result.half_widths[loaded]
print(f"within the stated 95 % interval: {100 * inside.mean():.1f} %")
assert off.mean() < 0.05 * off_raw.mean()
assert inside.mean() > 0.93

# %% Figures over time, a row a frame.
print(result.figures.to_pandas()[["force_newtons", "contact_area_mm2", "peak_kilopascals"]].describe().round(2))

# %% And a picture.
taxel.plot.heatmap(result).figure.savefig("first-look.png")
print("wrote first-look.png")
