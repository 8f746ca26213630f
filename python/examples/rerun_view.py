"""A recording in Rerun's viewer: loads over one range for all frames, marks, events, and figures over time.

    python rerun_view.py [RECORDING [SENSOR]] [--save FILE.rrd]

Needs `pip install rerun-sdk`. Without a recording it shows a virtual hand; where there is no screen it writes an .rrd file, which
`rerun FILE.rrd` or https://app.rerun.io opens.
"""

import argparse
import os
import sys

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

import taxel

# %% What to show: frames of counts to loads, with their marks and times.
arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("recording", nargs="?")
arguments.add_argument("sensor", nargs="?")
arguments.add_argument("--save", metavar="FILE.rrd", help="write a file, open no viewer")
asked = arguments.parse_args()
if asked.recording is None:
    grip = taxel.simulate("mat-16x16-cd4067", pattern="hand", frames=200, seed=1)
    sensor, events = taxel.Sensor("mat-16x16-cd4067"), []
    result = taxel.Pipeline(sensor).process(grip.counts, time=0.01 * np.arange(200))
else:
    recording = taxel.read(asked.recording, asked.sensor)
    sensor, events = recording.sensor, recording.events
    if sensor is None:
        raise SystemExit(f"{asked.recording} brings no sensor: name its file or preset behind it")
    result = taxel.Pipeline(sensor).process(recording)
values = result.loads if result.loads is not None else result.siemens
times = result.time if result.time is not None else np.arange(len(values), dtype=float)

# %% Where to: the viewer, or a file.
has_screen = sys.platform in ("darwin", "win32") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
layout = rrb.Blueprint(
    rrb.Horizontal(
        rrb.Spatial2DView(origin="mat", name=sensor.name),
        rrb.Vertical(
            rrb.TimeSeriesView(origin="figures/force_newtons", name="Total force (N)"),
            rrb.TimeSeriesView(origin="figures/contact_area_mm2", name="Contact area (mm²)"),
            rrb.TimeSeriesView(origin="figures/centre", name="Centre of pressure (mm)"),
            rrb.TextLogView(origin="events", name="Events"),
        ),
    )
)
rr.init("taxel", default_blueprint=layout)
if asked.save or not has_screen:
    file = asked.save or "taxel.rrd"
    rr.save(file)
else:
    file = None
    rr.spawn()

# %% Said once: the colours of marks, and the range of all frames. A range of each frame's own would flicker.
words = {code: word for word, code in taxel.MARKS.items()}
colours = {code: (53, 208, 255, 90) if code else (0, 0, 0, 0) for code in words}
classes = [rr.AnnotationInfo(id=code, label=word, color=colours[code]) for code, word in words.items()]
rr.log("mat", rr.AnnotationContext(classes), static=True)
most = float(np.max(values, initial=0.0)) or 1.0
rr.log("sensor", rr.TextDocument(sensor.to_toml()), static=True)

# %% Frame by frame. One unit is one newton (siemens without a load law): the viewer tells it of the taxel pointed at.
down, across = sensor.pitch_mm
for frame in range(len(values)):
    rr.set_time("frame", sequence=frame)
    rr.set_time("time", duration=float(times[frame]))
    rr.log("mat/loads", rr.DepthImage(values[frame].astype(np.float32), meter=1.0, colormap="inferno", depth_range=(0.0, most)))
    rr.log("mat/marks", rr.SegmentationImage(result.marks[frame], draw_order=1.0))
    if result.loads is None:
        continue
    for figure in ("force_newtons", "contact_area_mm2"):
        rr.log(f"figures/{figure}", rr.Scalars(result.figures[figure][frame]))
    x, y = (float(result.figures[f"centre_{axis}_mm"][frame]) for axis in "xy")
    has_centre = bool(np.isfinite([x, y]).all())
    if has_centre:
        rr.log("figures/centre/x", rr.Scalars(x))
        rr.log("figures/centre/y", rr.Scalars(y))
    # Where nothing presses there is none, rather than the one before. A taxel's middle is half a pixel in.
    place = [[x / across + 0.5, y / down + 0.5]] if has_centre and sensor.positions_mm is None else []
    rr.log("mat/centre", rr.Points2D(place, radii=0.3, colors=(255, 255, 255), draw_order=2.0))

# %% What happened meanwhile.
for event in events:
    rr.set_time("time", duration=float(event["secs"]))
    rr.log("events", rr.TextLog(f"{event['kind']}: {event['text']}"))
print(f"{len(values)} frames, 0 to {most:.3g} {'N' if result.loads is not None else 'S'}" + (f", in {file}" if file else ""))
