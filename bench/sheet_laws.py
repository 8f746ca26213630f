"""Sensors under films that keep to another law than the program's: what a calibration makes of them.

    python3 bench/sheet_laws.py target/release/taxel --folder drawn --seeds 11 12 13

Each sensor is an e-Cone's circuit (64 x 128, 16 bits, 3 counts of noise) with switches and taxels that differ, spread, saturation, an offset, memory
of the scan, loads held for unknown times while the material creeps, labels 2 % off and some presses off centre. Neighbours conduct to each
other through a film by one of four laws (f: load, g: conductance above nothing, of both):

    series    1 / (R + a (1/g + 1/g))               the program's own
    smaller   smaller of f / (f + 100 g), over 12 kOhm
    mean      geometric mean of g, saturating
    contact   geometric mean of f / (f + 200 g), over 10 kOhm

The circuit is solved here, by numpy, not by the program. It draws the loads that press (`taxel simulate --truth`), blobs and hands; feet are the mean
of 104 people in testdata/plantar. Calibrated as its owner would, judged the same day, a day later (3 % more conductance), and after
`taxel check`. Needs Python 3.10 and numpy.
"""

import argparse
import pathlib

import numpy as np

from uncertainty import array, parts_list, run

ROWS, COLUMNS = 64, 128
ROOT = pathlib.Path(__file__).parent.parent
LAWS = ("series", "smaller", "mean", "contact")


class Sensor:
    """What nobody knows of one: numpy's own circuit and material."""

    def __init__(self, seed, law):
        self.random = random = np.random.default_rng(seed)
        self.law = law
        near = lambda mean, share, shape=(): mean * (1 + share * random.standard_normal(shape))
        self.r_feedback, self.gain = near(2000, 0.005), 5000
        self.r_columns, self.r_rows = near(7.5, 0.1, COLUMNS), near(9.3, 0.1, ROWS)
        exponent = random.uniform(0.85, 1)
        factor = 2e-3 / 600**exponent * random.uniform(0.8, 1.2)
        self.factor = factor * np.exp(0.1 * random.standard_normal((ROWS, COLUMNS)))
        self.exponent = near(exponent, 0.02, (ROWS, COLUMNS))
        self.saturation = random.uniform(2500, 5000)
        self.to_row, self.to_column, self.across = random.uniform((0.01, 0.01, 0.002), (0.03, 0.03, 0.006))
        self.carry, self.offset = random.uniform(0.003, 0.01), random.uniform(-15, 15)
        self.film, self.contact = random.uniform(8e3, 20e3), random.uniform(2, 5)

    def acting(self, loads):
        padded = np.pad(loads, 1)
        at = lambda down, right: padded[1 + down : 1 + down + ROWS, 1 + right : 1 + right + COLUMNS]
        around = self.to_row * (at(1, 0) + at(-1, 0)) + self.to_column * (at(0, 1) + at(0, -1))
        around = around + self.across * (at(1, 1) + at(1, -1) + at(-1, 1) + at(-1, -1))
        return (1 - 2 * self.to_row - 2 * self.to_column - 4 * self.across) * loads + around

    def couplings(self, siemens, acting, axis):
        """Conductance from each taxel to the next along an axis."""
        both = lambda x: (x[:-1], x[1:]) if axis == 0 else (x[:, :-1], x[:, 1:])
        (g, h), (a, b) = both(siemens), both(acting)
        if self.law == "series":
            return 1 / (self.film + self.contact * (1 / g + 1 / h))
        if self.law == "smaller":
            return np.minimum(a / (a + 100), b / (b + 100)) / 12e3
        if self.law == "mean":
            return 0.35 * np.sqrt((g - 1e-6) * (h - 1e-6)) / (1 + 9e3 * np.sqrt(g * h))
        return np.sqrt(a / (a + 200) * b / (b + 200)) / 10e3

    def volts(self, siemens, acting):
        """Of the whole scan: nodes are the lines, one solve with nothing selected and an update for each row."""
        along_rows = laplacian(self.couplings(siemens, acting, 0).sum(1))
        along_columns = laplacian(self.couplings(siemens, acting, 1).sum(0))
        rows = np.diag(siemens.sum(1) + 1e-12) + along_rows
        columns = np.diag(siemens.sum(0) + 1 / self.r_columns) + along_columns
        inverse = np.linalg.inv(np.block([[rows, -siemens], [-siemens.T, columns]]))
        own, across = np.diag(inverse)[:ROWS], inverse[:ROWS, ROWS:]
        sensed = 1 / (self.r_rows + self.r_feedback / (1 + self.gain))
        amperes = 0.4 * sensed[:, None] * across / self.r_columns / (1 + sensed * own)[:, None]
        return self.r_feedback * self.gain / (1 + self.gain) * amperes

    def counts(self, loads, conducts):
        """Of a frame of loads, held for an unknown time: a material that conducts so much more than when it was calibrated."""
        crept = 0.98 + 0.02 * np.log10(1 + self.random.uniform(2, 40))
        acting = self.acting(loads)
        siemens = 1e-6 + conducts * crept * self.factor * acting**self.exponent / np.sqrt(1 + acting / self.saturation)
        scanned = (self.volts(siemens, acting) / 2.2 * 65535 + self.offset).T.ravel()
        scanned[1:] = (1 - self.carry) * scanned[1:] + self.carry * scanned[:-1].copy()
        counts = scanned.reshape(COLUMNS, ROWS).T
        return np.clip(np.round(counts + 3 * self.random.standard_normal(counts.shape)), 0, 65535).astype(int)


def laplacian(couplings):
    n = len(couplings) + 1
    matrix, i = np.zeros((n, n)), np.arange(n - 1)
    matrix[i, i] += couplings
    matrix[i + 1, i + 1] += couplings
    matrix[i, i + 1] -= couplings
    matrix[i + 1, i] -= couplings
    return matrix


def drawn(taxel, folder, pattern, frames, seed, *more):
    """Loads that the program draws, and its table of presses where there is one."""
    words = ["simulate", "--sensor", "econe", "--pattern", pattern, "--frames", frames, "--seed", seed, "--truth", folder / "t.csv"]
    run(taxel, *words, "-o", folder / "t.txt", *more)
    return np.loadtxt(folder / "t.csv", delimiter=",").reshape(-1, ROWS, COLUMNS)


def feet(random):
    """One foot or two, up to 600 g a taxel."""
    left, right = (np.loadtxt(ROOT / f"testdata/plantar/MUN104{side}.csv", delimiter=",") for side in "LR")
    height, width = left.shape
    frames = []
    for number in range(4):
        loads, first = np.zeros((ROWS, COLUMNS)), random.integers(0, COLUMNS - 2 * width - 4)
        for foot, at in [(left, first), (right, first + width + 4)][: 1 + number // 2]:
            loads[:height, at : at + width] = foot * random.uniform(300, 600) / foot.max()
        frames.append(np.where(loads < 2, 0, loads))
    return frames


def write(file, frames):
    file.write_text("".join(",".join(map(str, row)) + ",\n" for frame in frames for row in frame))


def presses(taxel, sensor, folder, name, count, seed, conducts, off_centre):
    """Labelled presses, labels 2 % off."""
    loads = drawn(taxel, folder, "press", count, seed, "--presses", folder / "p.csv")
    header, *rows = (line.split(",") for line in (folder / "p.csv").read_text().splitlines())
    table, frames = ["recording,frame,row,column,load_g"], []
    for number, (frame, row) in enumerate(zip(loads, rows)):
        told = dict(zip(header, row))
        r, c, load = int(told["row"]), int(told["column"]), float(told["load_g"])
        if sensor.random.random() < off_centre:
            down, right = ((0, 1), (0, -1), (1, 0), (-1, 0))[sensor.random.integers(4)]
            part = sensor.random.uniform(0.05, 0.25) * frame[r, c]
            frame[r, c] -= part
            frame[np.clip(r + down, 0, ROWS - 1), np.clip(c + right, 0, COLUMNS - 1)] += part
        frames.append(sensor.counts(frame, conducts))
        table.append(f"{name}.txt,{number},{r},{c},{load * (1 + 0.02 * sensor.random.standard_normal()):.2f}")
    write(folder / f"{name}.txt", frames)
    (folder / f"{name}.csv").write_text("\n".join(table) + "\n")
    return folder / f"{name}.csv"


def uniform(sensor, folder):
    table, frames = ["recording,frame,load_g"], []
    for load in (50, 150, 300):
        for _ in range(4):
            table.append(f"uniform.txt,{len(frames)},{load}")
            frames.append(sensor.counts(np.full((ROWS, COLUMNS), float(load)), 1))
    write(folder / "uniform.txt", frames)
    (folder / "uniform.csv").write_text("\n".join(table) + "\n")
    return folder / "uniform.csv"


def judge(taxel, calibrated, recording, true, folder):
    """Of three kinds of contact: error, share inside, half-width over error; unloaded outside; totals."""
    out = {name: folder / f"{name}.npz" for name in ("loads", "half", "marks")}
    run(taxel, "compensate", recording, "--sensor", calibrated, "--unit", "g", "-o", out["loads"], "--interval", out["half"], "--marks", out["marks"], good=(0, 3))
    loads, half, marks = (array(out[name]) for name in ("loads", "half", "marks"))
    # Unresolved: nothing is told from nothing, and the interval says so.
    good, off = np.isin(marks, (0, 8)), np.abs(loads - true)
    kinds = {"all": slice(None), "blobs": slice(0, 4), "hands": slice(4, 8), "feet": slice(8, 12)}
    said = []
    for kind, of in kinds.items():
        loaded, unloaded = (true[of] > 0) & good[of], (true[of] == 0) & good[of]
        inside, ratio = (off <= half)[of][loaded].mean(), np.median(half[of][loaded]) / np.median(off[of][loaded])
        total = loads[of].sum((1, 2)) / true[of].sum((1, 2)) - 1
        said.append(f"{kind} {off[of][loaded].mean():.2f} g, {100 * inside:.0f} % inside, half-width {ratio:.1f} errors, "
                    f"{100 * (off > half)[of][unloaded].mean():.1f} % unloaded outside, total {100 * total.mean():+.1f} %")
    return "; ".join(said)


def one(taxel, law, seed, folder):
    sensor = Sensor(seed, law)
    parts = parts_list(ROOT / "crates/taxel/src/sensor/presets/econe.toml", folder)
    labelled = presses(taxel, sensor, folder, "presses", 150, seed, 1, 0.15)
    even = uniform(sensor, folder)
    true = [*drawn(taxel, folder, "blobs", 4, seed + 500, "--load-g", 600), *drawn(taxel, folder, "hand", 160, seed + 500)[40::30][:4], *feet(sensor.random)]
    true = np.array(true)
    for day, conducts in (("same", 1), ("later", 1.03)):
        write(folder / f"{day}.txt", [sensor.counts(frame, conducts) for frame in true])
    calibrated, today = folder / "calibrated.toml", folder / "today.toml"
    said = run(taxel, "calibrate", "--sensor", parts, "--presses", labelled, "--equilibration", even, "-o", calibrated, good=(0, 3))
    if "took no part" in said:
        print(f"{law} {seed}: uniform loads took no part in the calibration, which is told to be wrong (exit code 3)")
    checked = presses(taxel, sensor, folder, "check", 12, seed + 900, 1.03, 0)
    run(taxel, "check", "--sensor", calibrated, "--presses", checked, "-o", today, good=(0, 3))
    for day, file, recording in (("same day", calibrated, "same"), ("later", calibrated, "later"), ("checked", today, "later")):
        print(f"{law} {seed}, {day}: {judge(taxel, file, folder / f'{recording}.txt', true, folder)}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taxel", type=pathlib.Path)
    parser.add_argument("--folder", type=pathlib.Path, required=True, help="where everything goes")
    parser.add_argument("--laws", nargs="*", default=LAWS, choices=LAWS)
    parser.add_argument("--seeds", nargs="*", type=int, default=[11, 12, 13])
    given = parser.parse_args()
    for law in given.laws:
        for seed in given.seeds:
            folder = given.folder / f"{law}-{seed}"
            folder.mkdir(parents=True, exist_ok=True)
            one(given.taxel.resolve(), law, seed, folder)


if __name__ == "__main__":
    main()
