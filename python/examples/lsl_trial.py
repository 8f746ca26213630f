"""A mat beside other devices: its loads by the lab streaming layer, recorded together with markers to an XDF file.

Needs `pip install pylsl pyxdf`. Any LSL program sees these streams: LabRecorder, EEGLAB, MNE, a stimulus program's markers beside them.
"""

import threading

import numpy as np
import pyxdf

import taxel
from taxel import lsl

# %% One program sends. Yours is at "serial:/dev/ttyACM0?baud=2000000"; this one is simulated.
source = taxel.live("sim:mat-16x16-cd4067?hand&fps=100")
sending = threading.Thread(target=lsl.send, args=(source,), kwargs={"name": "left hand", "rate": 100.0})
sending.start()

# %% Another, on this computer or any other of the network, receives.
with lsl.Inlet("left hand") as inlet:
    frames = inlet.read()
    print(f"{inlet.stream.name}: {inlet.shape[0]} × {inlet.shape[1]}, {inlet.unit}, of {inlet.sensor}")
    print(f"{frames.values[0].sum():.1f} N, {1000 * (lsl.clock() - frames.time[0]):.1f} ms ago")

# %% And a third records all that is there, each stream with its own clock.
for told in lsl.record("trial.xdf", ["left hand", "left hand marks"], seconds=2.0):
    print(told)
source.close()
sending.join()

# %% pyxdf brings the clocks together.
streams, _ = pyxdf.load_xdf("trial.xdf")
loads = streams[0]["time_series"].reshape(-1, 16, 16)
print(f"{len(loads)} frames over {np.ptp(streams[0]['time_stamps']):.2f} s, at most {loads.sum(axis=(1, 2)).max():.1f} N")
assert len(loads) > 100 and (np.diff(streams[0]["time_stamps"]) > 0).all()
