"""Load laws of one Velostat taxel, judged on robot presses that they were not fitted on.

    OMP_NUM_THREADS=1 python bench/velostat_press.py FOLDER

FOLDER holds robot/load-cell and robot/reading as its SOURCE.txt says: a UR5 presses one Velostat sensor at 16
positions, to about 5, 20 and 40 N, each force twice (exp1, exp2), next to a load cell. The data has no licence and is
therefore not in the repository; it comes from github.com/Lupasic/tactile-sensor-velostat. Needs numpy and scipy.

The laws, all from conductance over unloaded conductance to load:
    linear             load = conductance / k
    power              load = (conductance / k)^(1/b)
    power + log creep  the same, k growing with the logarithm of the time since the press began
    dynamic n+m        n creep lags and m hysteresis plays; equations in crates/taxel/src/calibrate/dynamic/mod.rs

The tests, each fitted on some presses and judged on others:
    files, one gain            fitted on exp1 of every force, judged on exp2
    files, gain per position   the same, with a gain for each of the 16 positions, fitted on exp1 as well
    positions, one gain        fitted on the positions 0, 2, 4.., judged on 1, 3, 5..
    forces, gain per position  fitted on 5 and 40 N, judged on 20 N
    shape only                 files, but the gain of each judged press comes from that press and its load: what is left
                               is the error in the shape over time and load. No sensor in use can do this.

One table comes out: mean absolute error under load in newtons, averaged within each press and then over presses, with
its 95 % bootstrap interval over presses; the same over samples; the mean error while unloaded; and, for the shape, how
far estimate / load moves from the start of a hold to its end, which is the creep that a law leaves (signed mean, mean
magnitude, and the one hold of 27 s).

How to read it:
- Contact position changes the gain up to tenfold (printed below the table; it repeats from exp1 to exp2), and no law of
  one taxel's history can undo that: a light press on a sensitive spot reads as a hard one on an insensitive spot does.
  Hence the errors with one gain, whatever the law. "Gain per position" has to be told where the contact is.
- With one gain, the laws with creep fit the differences between positions and not the creep; compare them by the shape.
- Presses at one position or in one file are not independent, so the true intervals are likely wider than those printed.
  All laws see the same presses, though: two laws may differ more clearly than their intervals tell.
- One press of the 20 N files (exp2) is held for 27 s, all others for 1.1 to 7 s. It weighs on the errors by sample,
  most with "forces", where no long hold is fitted.
- Given from the load and not from the reading: which position a sample belongs to. The unloaded conductance is the
  median of all six files, the judged ones included: a tare.
- One sensor, one indenter (pike1): nothing here speaks about other sheets, or about minutes and hours of load.
"""

import argparse
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

HZ = 20.0  # both recordings are averaged into common bins: the sensor has 142 Hz, the load cell 253 Hz
POSITIONS = 16
LOADED = 0.7  # newtons
GAIN_LOAD = 2.4  # newtons; gains come from samples above it, where noise and the tare matter little
ONSET = 2e-3  # conductance over the unloaded one from which a press counts as begun, for the creep of the log law
PRIOR = 2.0  # one standard deviation of ln(parameter) around its start: holds what the data does not tell


@dataclass
class Presses:
    """All files side by side, padded to the longest: arrays are (samples, files)."""

    load: np.ndarray  # newtons
    excess: np.ndarray  # conductance over the unloaded one, 1 / unit of the reading, not below 0
    held: np.ndarray  # seconds since the reading said that a press began, 0 between presses
    position: np.ndarray  # of the press that a sample belongs to, 0..15
    valid: np.ndarray  # False where padded
    spans: list  # of each file: (first, last) sample of each press

    @property
    def everything(self):
        return np.ones_like(self.valid)


# ---- data -----------------------------------------------------------------------------------------------------------


def read_columns(path):
    """(value, unix time) of every whole line; a recording may end within a line."""
    lines = (line.split() for line in path.read_text().splitlines())
    return np.array([line[:2] for line in lines if len(line) >= 2], float).T


def bin_means(times, values, bins):
    """Mean in each bin of 1 / HZ seconds from 0 on, empty bins interpolated."""
    index = np.floor(times * HZ).astype(int)
    inside = (index >= 0) & (index < bins)
    count = np.bincount(index[inside], minlength=bins)
    mean = np.bincount(index[inside], values[inside], bins) / np.maximum(count, 1)
    filled = np.flatnonzero(count)
    return np.interp(np.arange(bins), filled, mean[filled])


def find_presses(load):
    """(first, last) sample of each press: loaded, gaps below 1 s closed, longer than 0.6 s."""
    spans = []
    for sample in np.flatnonzero(load > LOADED):
        if spans and sample - spans[-1][1] < HZ:
            spans[-1][1] = sample
        else:
            spans.append([sample, sample])
    return [(first, last) for first, last in spans if last - first > 0.6 * HZ]


def read_presses(folder):
    files = []
    for path in sorted((folder / "robot" / "load-cell").glob("*/*.txt")):
        load, load_time = read_columns(path)
        reading, reading_time = read_columns(folder / "robot" / "reading" / path.parent.name / path.name)
        begin = load_time[0]
        bins = int((min(load_time[-1], reading_time[-1]) - begin) * HZ)
        load = bin_means(load_time - begin, load, bins)
        # The reading falls with force, as a resistance does.
        conductance = 1.0 / bin_means(reading_time - begin, reading, bins)
        spans = find_presses(load)
        assert len(spans) == POSITIONS, f"{path.name}: {len(spans)} presses"
        # Halfway between two presses the next position begins.
        position = np.zeros(bins, int)
        for press in range(1, POSITIONS):
            position[(spans[press - 1][1] + spans[press][0]) // 2 :] = press
        files.append((load, conductance, position, spans))
        holds = np.array([last - first for first, last in spans]) / HZ
        print(f"{path.stem}: {bins / HZ:.0f} s, {len(spans)} presses, loaded for {np.median(holds):.2f} s (median)")
    # The sorted order is 20, 40, 5 N and exp1 before exp2 in each; the tests below count on it.
    assert len(files) == 6, f"{len(files)} files, not 6"

    longest = max(len(file[0]) for file in files)

    def side_by_side(column, fill):
        padded = [np.pad(f[column], (0, longest - len(f[column])), constant_values=fill(f)) for f in files]
        return np.stack(padded, axis=1)

    load = side_by_side(0, lambda _: 0.0)
    conductance = side_by_side(1, lambda file: np.median(file[1][file[0] < 0.05]))
    valid = np.arange(longest)[:, None] < [len(file[0]) for file in files]
    unloaded = np.median(conductance[(load < 0.05) & valid])
    excess = np.maximum(conductance - unloaded, 0.0)
    held = np.zeros_like(excess)
    for sample in range(longest):
        held[sample] = np.where(excess[sample] > ONSET, held[sample - 1] + 1 / HZ, 0.0)
    position = side_by_side(2, lambda _: POSITIONS - 1)
    return Presses(load, excess, held, position, valid, [file[3] for file in files])


# ---- laws: load from the logarithms of the parameters, excess conductance (gain divided out) and time held ----------


def linear(logs, excess, _held):
    return excess / np.exp(logs[0])


def power(logs, excess, _held):
    return (excess / np.exp(logs[0])) ** np.exp(-logs[1])


def log_creep(logs, excess, held):
    creep = 1 + np.exp(logs[2]) * np.log1p(held / np.exp(logs[3]))
    return (excess / np.exp(logs[0]) / creep) ** np.exp(-logs[1])


def dynamic(lags, plays):
    """Inverse of the dynamic law, frame by frame in closed form, as `Memory` of the crate has it but in newtons.

    It begins at rest and without load, as every file does.
    """

    def law(logs, excess, _held):
        # Far outside lies nothing but overflow.
        scale, exponent, *rest = np.exp(np.clip(logs, -25, 8))
        lag_weight, lag_secs, play_weight, half_width = np.split(np.array(rest), np.cumsum([lags, lags, plays]))
        # The closed form takes the plays in the order in which they begin to move.
        order = np.argsort(half_width)
        play_weight, half_width = play_weight[order], half_width[order]

        # s <- keep s + old F(before) + new F is exact for a load that runs straight between samples.
        part = 1 / HZ / lag_secs
        gone = -np.expm1(-part)
        new = np.where(part < 1e-4, part / 2, 1 - gone / part)
        keep, old = (1 - gone)[:, None], (gone - new)[:, None]
        new = new[:, None]
        free_slope = 1 + lag_weight @ new[:, 0]
        give = play_weight / (free_slope + np.cumsum(play_weight))

        acting = (excess / scale) ** (1 / exponent)
        load = np.empty_like(acting)
        creep = np.zeros((lags, acting.shape[1]))
        play = np.zeros((plays, acting.shape[1]))
        before = np.zeros(acting.shape[1])
        for sample, x in enumerate(acting):
            past = keep * creep + old * before
            force = (x - lag_weight @ past - play_weight @ play) / free_slope
            # One kink for each play: beyond it the play moves along and takes its share.
            for centre, reach, share in zip(play, half_width, give):
                above, below = force - (centre + reach), (centre - reach) - force
                force = force - share * np.maximum(above, 0) + share * np.maximum(below, 0)
            force = np.maximum(force, 0)
            creep = past + new * force
            play = np.minimum(np.maximum(play, force - half_width[:, None]), force + half_width[:, None])
            load[sample] = before = force
        return load

    return law


def dynamic_start(lags, plays):
    """scale, exponent, lag weights, lag seconds, play weights, play half-widths (newtons), as logarithms."""
    lag_secs, half_width = np.geomspace(0.15, 6, lags), np.geomspace(0.5, 5, plays) if plays > 1 else [1.0]
    return np.log(np.concatenate([[3e-3, 0.9], np.full(lags, 0.1), lag_secs, np.full(plays, 0.1), half_width]))


LAWS = {
    "linear": (linear, np.log([4e-3])),
    "power": (power, np.log([4e-3, 0.9])),
    "power + log creep": (log_creep, np.log([4e-3, 0.9, 0.1, 0.3])),
    "dynamic 2+1": (dynamic(2, 1), dynamic_start(2, 1)),
    "dynamic 3+3": (dynamic(3, 3), dynamic_start(3, 3)),
}


# ---- fit ------------------------------------------------------------------------------------------------------------


def estimate(law, logs, presses, files, gains):
    """Loads of these files, with these gains by position."""
    gain = gains[presses.position[:, files]]
    return law(logs, presses.excess[:, files] / gain, presses.held[:, files])


def fit_gains(law, logs, presses, files, gains, chosen):
    """Gain of each position, by which the median of estimate / load becomes 1."""
    gains = gains.copy()
    load, position = presses.load[:, files], presses.position[:, files]
    usable = chosen[:, files] & (load > GAIN_LOAD)
    # A gain acts on the conductance, so a ratio of loads is a gain to the power of 1 / exponent. Creep and plays carry
    # from press to press, which is why once is not enough.
    exponent = np.exp(logs[1]) if len(logs) > 1 else 1.0
    for _ in range(4):
        found = estimate(law, logs, presses, files, gains)
        for place in range(POSITIONS):
            here = usable & (position == place)
            if here.sum() > 3:
                ratio = np.median(found[here] / load[here])
                gains[place] *= np.clip(ratio, 0.3, 3) ** exponent
    return gains


def fit(law, start, presses, files, chosen, by_position):
    """Parameters (logarithms) and gains from the chosen samples of these files, unloaded samples included."""
    logs, gains = start.copy(), np.ones(POSITIONS)
    used = chosen[:, files] & presses.valid[:, files]
    load = presses.load[:, files]

    def residuals(trial):
        error = (estimate(law, trial, presses, files, gains) - load)[used]
        return np.append(error, (trial - start) / PRIOR)

    for turn in range(3 if by_position else 1):
        if by_position:
            gains = fit_gains(law, logs, presses, files, gains, chosen)
            if turn == 0:  # the scale of the law takes the mean
                gains /= np.exp(np.log(gains).mean())
        # soft_l1: the edges of a press, where the two clocks matter, must not rule the fit. 12 evaluations: the gains
        # move between the turns anyway.
        logs = least_squares(residuals, logs, loss="soft_l1", f_scale=0.5, max_nfev=12, diff_step=1e-4).x
    if by_position:
        gains = fit_gains(law, logs, presses, files, gains, chosen)
    return logs, gains


# ---- judge ----------------------------------------------------------------------------------------------------------


def judge(found, presses, files, chosen):
    """Error under load by press with its interval and by sample, error while unloaded; newtons."""
    considered = chosen[:, files] & presses.valid[:, files]
    loaded = considered & (presses.load[:, files] > LOADED)
    error = np.abs(found - presses.load[:, files])
    by_press = []
    for column, file in enumerate(files):
        for place in range(POSITIONS):
            here = loaded[:, column] & (presses.position[:, file] == place)
            if here.sum() > 3:
                by_press.append(error[here, column].mean())
    by_press = np.array(by_press)
    rng = np.random.default_rng(0)
    resampled = [rng.choice(by_press, len(by_press)).mean() for _ in range(500)]
    low, high = np.percentile(resampled, [2.5, 97.5])
    unloaded = error[considered & ~loaded].mean()
    interval = f"{low:.2f}-{high:.2f}"
    return f"{len(by_press):7d} {by_press.mean():8.2f} {interval:>12} {error[loaded].mean():9.2f} {unloaded:9.3f}"


def hold_drift(found, presses, files):
    """ln of how far estimate / load moves from the start of a hold to its end, and that of the one long hold."""
    drifts, longest = [], np.nan
    for column, file in enumerate(files):
        load = presses.load[:, file]
        for first, last in presses.spans[file]:
            top = np.percentile(load[first:last], 70)
            hold = first + np.flatnonzero(load[first : last + 1] > 0.85 * top)
            if len(hold) < 15:
                continue
            # A quarter of a second each, away from the edges.
            ratios = [
                found[part, column].mean() / load[part].mean()
                for part in (slice(hold[0] + 4, hold[0] + 9), slice(hold[-1] - 6, hold[-1] - 1))
            ]
            drifts.append(np.log(ratios[1] / ratios[0]))
            if last - first > 20 * HZ:
                longest = drifts[-1]
    drifts = np.array(drifts)
    return f"{100 * drifts.mean():+9.1f} {100 * np.abs(drifts).mean():9.1f} {100 * longest:+9.1f}"


def judge_law(law, start, presses):
    """{test: columns of its row}, and how far the largest gain of a position is from the smallest."""
    whole, one_gain = presses.everything, np.ones(POSITIONS)
    first, second, every = np.array([0, 2, 4]), np.array([1, 3, 5]), np.arange(6)
    rows = {}

    logs, _ = fit(law, start, presses, first, whole, False)
    rows["files, one gain"] = judge(estimate(law, logs, presses, second, one_gain), presses, second, whole)

    logs, gains = fit(law, start, presses, first, whole, True)
    found = estimate(law, logs, presses, second, gains)
    rows["files, gain per position"] = judge(found, presses, second, whole)

    own = [
        estimate(law, logs, presses, [file], fit_gains(law, logs, presses, [file], gains, whole)) for file in second
    ]
    own = np.concatenate(own, axis=1)
    shape = judge(own, presses, second, whole) + " " + hold_drift(own, presses, second)

    even = presses.position % 2 == 0
    halved, _ = fit(law, start, presses, every, even, False)
    found = estimate(law, halved, presses, every, one_gain)
    rows["positions, one gain"] = judge(found, presses, every, ~even)

    outer, middle = np.array([2, 3, 4, 5]), np.array([0, 1])
    outer_logs, outer_gains = fit(law, start, presses, outer, whole, True)
    found = estimate(law, outer_logs, presses, middle, outer_gains)
    rows["forces, gain per position"] = judge(found, presses, middle, whole)

    rows["shape only"] = shape
    return rows, np.exp(logs)


def describe_gains(presses):
    """How much the gain differs between positions, press by press, and how well it repeats: of the linear law."""
    law, start = LAWS["linear"]
    ones, whole = np.ones(POSITIONS), presses.everything
    gains = np.array([fit_gains(law, start, presses, [file], ones, whole) for file in range(6)])
    spread = gains.max(axis=1) / gains.min(axis=1)
    alike = np.corrcoef(np.log(gains))
    repeat = min(alike[0, 1], alike[2, 3], alike[4, 5])
    return (
        f"gain of the linear law, largest over smallest position of a file: {spread.min():.1f} to {spread.max():.1f}\n"
        f"correlation of its logarithm over positions: exp1 with exp2 at least {repeat:.2f}, "
        f"any two files at least {alike.min():.2f}"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="with robot/load-cell and robot/reading")
    presses = read_presses(parser.parse_args().folder)
    mean_load = presses.load[(presses.load > LOADED) & presses.valid].mean()
    print(f"mean load under load {mean_load:.2f} N\n")

    begun, judged = time.perf_counter(), {}
    for name, (law, start) in LAWS.items():
        with np.errstate(over="ignore", invalid="ignore"):  # steps of the fit that are not taken
            judged[name] = judge_law(law, start, presses)

    print(f"{'':45} {'N, by':>16} {'95 %':>12} {'N, by':>9} {'N,':>9}    drift in a hold, %")
    print(
        f"{'fitted and judged on':26} {'law':18} {'presses':>7} {'press':>8} {'interval':>12} {'sample':>9} "
        f"{'unloaded':>9} {'mean':>9} {'magnitude':>9} {'27 s':>9}"
    )
    for test in judged["linear"][0]:
        for name, (rows, _) in judged.items():
            print(f"{test:26} {name:18} {rows[test]}")
        print()
    print(describe_gains(presses))
    print("\nparameters fitted with files, gain per position (newtons, seconds):")
    for name, (_, parameters) in judged.items():
        print(f"{name:18} " + " ".join(f"{p:.4g}" for p in parameters))
    print(f"{time.perf_counter() - begun:.0f} s")


if __name__ == "__main__":
    main()
