"""An archive: recordings of several people to loads, figures over time and one table.

Three people's hands are simulated here; with your own recordings, the first line is
`paths = sorted(glob.glob("study/*/*.mcap"))`. Run it again: what is done is not done again.
"""

import os

import pandas as pd

import taxel

# %% Recordings, one of them cut off in the middle of a frame.
paths = []
for person in range(3):
    for trial in range(2):
        path = f"study/person{person}/trial{trial}.mcap"
        if not os.path.exists(path):
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with taxel.live(f"sim:mat-32x32-adg732?fingers&fps=1000&seed={2 * person + trial}", record=path) as frames:
                for frame in frames:
                    if frame.number >= 60:
                        break
        paths.append(path)
with open(paths[0], "rb") as file:
    start = file.read(os.path.getsize(paths[0]) // 2)
with open("study/cut.mcap", "wb") as file:
    file.write(start)
paths.append("study/cut.mcap")

# %% All of it: loads, figures, pictures, and a row each.
table = taxel.map(paths, "results", pictures=True).to_pandas()
print(table[["recording", "status", "frames", "peak_force_n", "peak_force_half_width_n"]].round(3).to_string())
assert table["status"].tolist() == 6 * ["done"] + ["incomplete"]

# %% Persons beside each other.
whole = table[table["status"] == "done"]
person = whole["recording"].str.extract(r"(person\d+)")[0]
print(whole.groupby(person)["peak_force_n"].agg(["mean", "std"]).round(2))

# %% Of one recording, the figures over time and the loads themselves.
figures = pd.read_csv("results/study/person1/trial0.mcap.figures.csv")
print(figures[["time_s", "total_force_N", "contact_area_mm2"]].describe().round(2))
