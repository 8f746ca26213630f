"""A grip over time: record live frames, and draw total force with its 95 % interval."""

import taxel

# %% Two seconds of a sensor. Yours is at "serial:/dev/ttyACM0?baud=2000000"; this one is simulated.
with taxel.live("sim:econe?fingers&fps=100", record="grip.mcap") as source:
    for frame in source:
        if frame.number >= 100:
            break
    print(source.statistics)

# %% The recording brings its sensor and its times. Some frames at a time: memory does not grow with its length.
recording = taxel.read("grip.mcap")
print(recording)
pipeline = taxel.Pipeline(recording.sensor)
most = max(float(part.figures["force_newtons"].max()) for part in pipeline.stream(recording))
print(f"most: {most:.1f} N")

# %% All at once, with errors.
result = taxel.Pipeline(recording.sensor).process(recording, standard_errors=True)
taxel.plot.over_time(result).figure.savefig("grip.png")
result.figures.to_csv("grip.csv")
assert abs(result.figures["force_newtons"].max() - most) < 0.01 * most
print("wrote grip.png and grip.csv")
