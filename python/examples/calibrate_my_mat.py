"""Calibrate a mat: known loads on single taxels become a sensor file with everything that a parts list does not say.

A mat drawn about the parts list stands in for the one on your table: its switches, taxels and resistor differ from it.
"""

import numpy as np

import taxel

# %% What you know: the parts. What a taxel conducts under a load, nobody knows yet.
tables = taxel.Sensor("mat-32x32-adg732").to_dict()
del tables["material"]
parts = taxel.Sensor(tables)
print(parts)

# %% What you do: press single taxels with known loads, and note row, column and load of each.
rng = np.random.default_rng(7)
presses = 80
row, column = rng.integers(0, 32, presses), rng.integers(0, 32, presses)
load = rng.uniform(0.5, 5.0, presses)
loads = np.zeros((presses, 32, 32))
loads[np.arange(presses), row, column] = load
pressed = taxel.simulate("mat-32x32-adg732", loads, seed=7, imperfect=True)

# %% One line of this mat is broken, as of many: a press that reads nothing tells nothing of the circuit.
answers = pressed.counts[np.arange(presses), row, column] > 20
print(f"{presses - answers.sum()} presses read nothing: rows {np.unique(row[~answers])}, columns {np.unique(column[~answers])}")

# %% The fit: numbers with their errors, and what is left of presses that it has not seen.
frame = np.arange(presses)[answers]
labelled = taxel.Presses(pressed.counts, frame, row[answers], column[answers], load[answers])
calibration = taxel.calibrate(parts, labelled)
print(calibration)
calibration.save("calibrated.toml")
with open("calibration.png", "wb") as file:
    file.write(calibration.picture("png"))

# %% Frames that the fit has not seen: how far off, and how often within what the sensor says of itself?
test = taxel.simulate(pressed.truth, pattern="blobs", frames=30, seed=8)
pipeline = taxel.Pipeline(calibration.sensor)
print(pipeline.look_for_faults(test.counts))
found = pipeline.process(test.counts, standard_errors=True)
# The broken line reads nothing: its taxels are marked, and their errors are infinite.
judged = (test.loads > 0.05) & np.isfinite(found.standard_errors)
off = np.abs(found.loads - test.loads)[judged]
share = off.mean() / test.loads[judged].mean()
inside = np.mean(off <= found.half_widths[judged])
print(f"mean error {off.mean():.3f} N, {100 * share:.1f} % of the mean load; {100 * inside:.1f} % within the stated 95 % interval")
assert share < 0.15 and inside > 0.9
