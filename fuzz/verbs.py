"""Each verb of the program with sound inputs and some of its options: what broken_inputs.py runs. Not a command of its own."""

import shlex


class Case:
    def __init__(self, verb, argv, outputs=(), stdin=None, breakable=None, judge=None):
        self.verb, self.argv, self.outputs, self.stdin = verb, argv, set(outputs), stdin
        self.breakable, self.judge = breakable, judge
        self.broken = ""


RECORDINGS = ["r.txt", "r.csv", "r.npy", "r.npz", "r.mcap", "r.mcap", "made.mcap", "r.parquet", "float.txt"]


def recording(rng):
    return rng.choice(RECORDINGS)


def sensor(rng):
    return rng.choice(["s.toml", "s.toml", "full.toml", "dynamic.toml", "float.toml"])


def some(rng, *options):
    """Some of the options, each with its value."""
    return [word for option in options if rng.random() < 0.25 for word in shlex.split(option)]


def info(rng):
    name = recording(rng)
    with_sensor = ["--sensor", sensor(rng)] if rng.random() < 0.5 else ["--rows", "4"] if not name.endswith("mcap") else []
    return Case("info", ["info", name, *with_sensor, *some(rng, "--json", "--keep-going", "--values")])


def compensate(rng):
    name, to = recording(rng), rng.choice(["l.csv", "l.npy", "l.npz", "l.mcap", "l.parquet", "l.txt"])
    method = ["--method", rng.choice(["raw", "exact", "newton", "mlp.safetensors", "rowset.safetensors", "hybrid.safetensors"])] if rng.random() < 0.4 else []
    outputs = {to, "l.marks.csv", "l.marks.npy", "l.marks.npz", "se.csv", "m.csv"}
    unit = rng.choice(["g", "N", "kPa", "volts", "siemens"])
    options = some(rng, "--standard-error se.csv", "--marks m.csv", "--keep-going", "--repair", "--json")
    where = ["-o", to] if rng.random() < 0.8 or options else []
    if rng.random() < 0.15:
        return Case("compensate", ["compensate", "siemens.csv" if rng.random() < 0.5 else "siemens.npy", "--sensor", sensor(rng), "--input-unit", "siemens", *where], outputs)
    return Case("compensate", ["compensate", name, "--sensor", sensor(rng), "--unit", unit, *method, *options, *where], outputs)


def calibrate_presses(rng):
    more = ["--equilibration", "equilibration.csv"] if rng.random() < 0.4 else []
    return Case("calibrate presses", ["calibrate", "--sensor", rng.choice(["parts.toml", "s.toml", "full.toml"]), "--presses", "experiments.csv", *more,
                                      *some(rng, rng.choice(["--law power", "--law spline"]), "--per-line", "--folds 3", "--json", "--fit-source"), "-o", "k.toml"],
                {"k.toml", "k.gain.csv", "k.exponent.csv", "k-gain.csv", "k-exponent.csv"}, breakable=["experiments.csv", "p.txt", "equilibration.csv", "even.txt", "parts.toml"])


def calibrate_pairs(rng):
    return Case("calibrate pairs", ["calibrate", "--sensor", rng.choice(["parts.toml", "s.toml"]), "--pairs", "pairs.csv", *some(rng, "--json", "--folds 3"), "-o", "k.toml"], {"k.toml"})


def calibrate_series(rng):
    return Case("calibrate series", ["calibrate", "--sensor", "s.toml", "--series", "series.csv", "--loads", "series-loads.csv", "--period", "0.1",
                                     "--lags", "1", "--plays", "1", *some(rng, "--static-output st.toml"), "-o", "k.toml"], {"k.toml", "st.toml"})


def analyse(rng):
    name, to = recording(rng), rng.choice(["a.png", "a.svg"])
    which = rng.choice([["--taxel", "1,2"], ["--taxel", "C1"], ["--row", "2"], ["--column", "1"], ["--region", "0..2,1..3"]])
    with_sensor = ["--sensor", sensor(rng), "--unit", rng.choice(["g", "volts", "siemens"])] if rng.random() < 0.6 else ["--rows", "4"] if not name.endswith("mcap") else []
    export = rng.choice([[], ["--export", "e.csv"], ["--export", "e.xlsx"], ["--export", "e.parquet"]])
    return Case("analyse", ["analyse", name, *which, *with_sensor, *some(rng, "--json", "--keep-going", "--frames-per-second 10"), *export, "-o", to], {to, "e.csv", "e.xlsx", "e.parquet"})


def plot(rng):
    name, to = recording(rng), rng.choice(["a.png", "a.svg"])
    which = rng.choice([["--frame", "3"], ["--frames", "0..4"], ["--taxel", "1,2"], ["--row", "1"], []])
    return Case("plot", ["plot", name, "--sensor", sensor(rng), *which, *some(rng, rng.choice(["--raw", "--before-after", "--values"]), "--interpolation nearest"), "-o", to], {to})


def convert(rng):
    name = rng.choice(["r.txt", "r.csv", "r.npy", "r.npz", "r.npz", "r.mcap", "r.mcap", "r.mcap", "made.mcap", "r.parquet"])
    to = rng.choice(["o.txt", "o.csv", "o.npy", "o.npz", "o.mcap", "o.parquet"])
    checked = name in ("r.mcap", "made.mcap", "r.npz")
    with_sensor = [] if name.endswith(("mcap", "parquet")) and rng.random() < 0.8 else ["--sensor", "s.toml"]
    return Case("convert", ["convert", name, *with_sensor, *some(rng, "--keep-going", "--fps 20"), "-o", to], {to},
                breakable=[name] if rng.random() < 0.85 else None, judge=(name, to) if checked and to != "o.parquet" else None)


def recover(rng):
    name = rng.choice(["r.mcap", "r.mcap", "made.mcap"])
    return Case("recover", ["recover", name, "-o", "o.mcap"], {"o.mcap"}, judge=(name, "o.mcap"))


def replay(rng):
    name = recording(rng)
    return Case("replay", ["replay", name, "--to", rng.choice(["udp:127.0.0.1:9", "-"]), *(["--sensor", "s.toml"] if not name.endswith("mcap") else []), "--speed", "0"])


def selftest(rng):
    return Case("selftest", ["selftest", "--empty", rng.choice(["empty.txt", "r.npy", "r.mcap"]), "--rubbed", recording(rng),
                             "--sensor", sensor(rng), *some(rng, "--json", "-o h.png", "--rate 100")], {"h.png"})


def evaluate(rng):
    verb = rng.choice(["evaluate", "evaluate", "report"])
    return Case(verb, [verb, "plan.toml", *(["-o", "rep.html"] if verb == "report" or rng.random() < 0.3 else [])], {"rep.html"},
                breakable=["plan.toml", "plan.toml", "trials.csv", "response.csv", "experiments.csv", "s.toml", "r.txt", "loads.csv", "even.txt", "p.txt"])


def simulate(rng):
    to = rng.choice(["o.txt", "o.csv", "o.npy", "o.npz"])
    if rng.random() < 0.6:
        return Case("simulate", ["simulate", "--sensor", sensor(rng), "--conductance", rng.choice(["siemens.csv", "siemens.npy"]), "--unit", rng.choice(["volts", "counts"]), "-o", to], {to})
    return Case("simulate", ["simulate", "--sensor", sensor(rng), "--pattern", rng.choice(["hand", "feet", "press", "blobs", "uniform", "random"]), "--frames", "3",
                             *some(rng, "--load-g 100", "--seed 5", "--period 0.1", "--imperfect uneven", "--imperfect beyond", "--truth t.csv", "--truth-sensor ts.toml"), "-o", to],
                {to, "t.csv", "ts.toml", "ts.gain.csv", "ts.exponent.csv", "ts-gain.csv", "ts-exponent.csv"})


def netlist(rng):
    which = rng.choice([["r.txt"], ["--conductance", "siemens.csv"], ["r.npz"], []])
    return Case("netlist", ["netlist", "--sensor", sensor(rng), *which, *some(rng, "--frame 2", "--taxel 1,1", "--scan"), "-o", "n.cir"], {"n.cir"})


def budget(rng):
    return Case("budget", ["budget", sensor(rng), *some(rng, "--frame r.txt:1", "--rate 60", "--full-load 500", "--json"), "--draws", "1"])


def design(rng):
    return Case("design", ["design", "--taxel", "500..3000", "--rows", "8", "--columns", "8", *some(
        rng, "--topology divider-floating", "--switch 70", "--gbw 5MHz", "--bits 12", "--full-scale 3.3", "--rate 50", "--full-load 500g", "--exponent 0.9", "--capacitance 100pF",
        "--taxel-current 1mA", "--headroom 10", "--pitch 3", "--v-test 0.3", "--resistor 1000", "--json"), "-o", "d.toml"], {"d.toml"}, breakable=["argument"])


def rig(rng):
    return Case("rig", ["rig", *rng.choice([["--pressure", "0.2MPa"], ["--load", "132g"], ["--margin", "5g", "--spread", "12g"], ["--shares", "22,5"]]),
                        *some(rng, "--spring 0.2", "--area 5", "--offset 2", "--confidence 90", "--power 90", "--json")], breakable=["argument"])


def crosstalk(rng):
    to = rng.choice(["c.png", "c.svg"])
    return Case("crosstalk", ["crosstalk", *some(rng, "--setting A=1e4,R_k=1000", "--volts-per-count 0.001", "--csv"), "-n", "8", "--points", "points.csv", *(["-o", to] if rng.random() < 0.5 else [])], {to})


def dataset(rng):
    if rng.random() < 0.2:
        return Case("dataset", ["dataset", "--sensor", sensor(rng), "--simulate", "3", "--shard", "2", "-o", "folder"], {"folder"})
    to = rng.choice(["o.csv", "o.npz"])
    return Case("dataset", ["dataset", "--sensor", "s.toml", "--presses", "experiments.csv", *(["--rows", "rows.csv"] if to == "o.csv" and rng.random() < 0.5 else []), "-o", to], {to},
                breakable=["experiments.csv", "p.txt", "rows.csv", "s.toml"])


def train(rng):
    kind = rng.choice([["paper-mlp", "--epochs", "1", "--copies", "1"], ["row-set", "--epochs", "1", "--members", "1"], ["hybrid", "--epochs", "1"]])
    source = rng.choice([["--presses", "experiments.csv"], ["--rows", "rows.csv"]]) if kind[0] != "hybrid" else ["--presses", "experiments.csv"]
    return Case("train", ["train", *kind, "--sensor", "s.toml", *source, *some(rng, "--test-share 0.2", "--check-share 0.2", "--seed 3", "--json"), "-o", "o.safetensors"],
                {"o.safetensors", "o.safetensors.checkpoint"}, breakable=["experiments.csv", "p.txt", "rows.csv", "s.toml"])


def compare(rng):
    sources = ["--presses", "experiments.csv"] if rng.random() < 0.7 else ["--rows", "rows.csv"]
    more = ["r.txt", "--truth", "loads.csv"] if rng.random() < 0.3 else []
    return Case("compare", ["compare", *more, "--sensor", rng.choice(["s.toml", "parts.toml"]), *sources, "--epochs", "1", "--copies", "1", "--without", "paper-mlp", "--without", "row-set",
                            "--without", "hybrid", "-o", "t.csv"], {"t.csv"}, breakable=["experiments.csv", "p.txt", "rows.csv", "s.toml", "r.txt", "loads.csv"])


def model(rng):
    name = rng.choice(["mlp.safetensors", "rowset.safetensors", "hybrid.safetensors"])
    how = rng.randrange(4)
    if how == 0:
        return Case("model show", ["model", "show", name])
    if how == 1:
        return Case("model export", ["model", "export", "mlp.safetensors", "-o", "o.onnx"], {"o.onnx"})
    if how == 2:
        return Case("model import", ["model", "import", "mlp.onnx", "--sensor", "s.toml", "--presses", "experiments.csv", "-o", "o.safetensors"], {"o.safetensors"}, breakable=["mlp.onnx"])
    return Case("model used", ["compensate", "r.txt", "--sensor", "s.toml", "--method", name, "-o", "l.csv"], {"l.csv", "l.marks.csv"}, breakable=[name])


def record(rng):
    name, protocol = rng.choice([("wire.bin", "taxel-1"), ("wire.bin", "taxel-1"), ("frame-lines.log", "lines"), ("row-lines.log", "lines"), ("econe.log", "econe-text")])
    address = "stdin:" + (f"?protocol={protocol}" if rng.random() < 0.5 else "")
    return Case("record stdin", ["record", address, "--sensor", "s.toml", *some(rng, "--loads", "--figures", "--frames 10"), "-o", "o.mcap"], {"o.mcap"}, stdin=name,
                breakable=["stdin", "stdin", "stdin", "stdin", "s.toml"], judge=("wire", "o.mcap") if protocol == "taxel-1" else None)


def record_file(rng):
    name = rng.choice(["r.txt", "r.csv", "r.mcap", "made.mcap", "r.npy"])
    return Case("record file", ["record", f"file:{name}?speed=max", "--sensor", "s.toml", *some(rng, "--loads", "--figures", "--frames 5"), "-o", "o.mcap"], {"o.mcap"}, breakable=[name, name, "s.toml"])


def from_stdin(rng):
    """Text on standard input."""
    verb = rng.choice([["info", "-", "--sensor", "s.toml"], ["compensate", "-", "--sensor", "s.toml", "-o", "l.csv"], ["compensate", "-", "--sensor", "s.toml"],
                       ["simulate", "--sensor", "s.toml", "--conductance", "-"]])
    return Case("text on stdin", verb, {"l.csv", "l.marks.csv"}, stdin="siemens.csv" if verb[0] == "simulate" else "r.txt", breakable=["stdin"])


RECIPES = [(info, 8), (compensate, 14), (calibrate_presses, 6), (calibrate_pairs, 4), (calibrate_series, 3), (analyse, 6), (plot, 6), (convert, 10), (recover, 10), (replay, 4),
           (selftest, 4), (evaluate, 6), (simulate, 4), (netlist, 3), (budget, 3), (design, 2), (rig, 1), (crosstalk, 2), (dataset, 3), (train, 3), (compare, 1), (model, 6),
           (record, 9), (record_file, 3), (from_stdin, 3)]
