"""Every case, every entry: draws, runs, judges, and writes the table.

    python3 run.py --taxel PROGRAM --write            # all of it; docs/ghosting.md and a table of figures in bench/runs
    python3 run.py --taxel PROGRAM --quick            # one case of 8 × 8, one seed, the quick entries
    python3 run.py --taxel PROGRAM --only CASE --entries 'one curve' --add mine.toml

Cases are kept in --work and drawn once; so are scores, unless --fresh. One entry at a time, on one core.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import generate
import report
from case import NOT_FOR_ME
from score import Refused, score

HERE = Path(__file__).resolve().parent
LIMIT_S = 600
LONGEST_REASON = 300
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "RAYON", "TAXEL")}
QUICK = {"case": "ideal-8x8-grounded", "entries": ["taxel exact", "one curve", "nodal fixed point"]}


def entries_of(files):
    entries = []
    for file in files:
        file = Path(file).resolve()
        for entry in tomllib.loads(file.read_text())["entry"]:
            places = {"python": sys.executable, "entries": str(HERE / "entries"), "here": str(file.parent)}
            entries.append({**entry, "command": [word.format(**places) for word in entry["command"]]})
    names = [entry["name"] for entry in entries]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise SystemExit(f"run.py: two entries are called {', '.join(sorted(twice))}; each needs a name of its own")
    return entries


def run_entry(entry, given, truth, work, taxel):
    """One entry on one case with one seed: figures, or why there are none."""
    out = work / "out" / given.name / entry["name"].replace(" ", "-").replace(",", "")
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    place = {"GHOSTING_CACHE": str(work / "cache" / given.name), "TAXEL": taxel}
    start = time.perf_counter()
    try:
        done = subprocess.run(
            [*entry["command"], str(given), str(out)],
            capture_output=True, text=True, timeout=LIMIT_S, env={**os.environ, **ONE_THREAD, **place},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return {"failed": f"took longer than {LIMIT_S} s"}
    except OSError as error:
        return {"failed": f"could not be started: {error}"}
    (out / "said.txt").write_text(done.stdout + done.stderr)
    if done.returncode == NOT_FOR_ME:
        return {"declined": done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "no reason given"}
    if done.returncode:
        said = done.stderr.strip() or f"exit code {done.returncode}"
        return {"failed": " / ".join(said[-LONGEST_REASON:].splitlines())}
    try:
        return score(given, truth, out) | {"wall_s": time.perf_counter() - start}
    except Refused as refused:
        return {"failed": str(refused).splitlines()[0]}


def run_all(cases, entries, work, taxel, fresh):
    """All figures, by case, entry and seed."""
    if fresh:
        shutil.rmtree(work / "cache", ignore_errors=True)
    found = []
    for case in cases:
        for seed in case["seeds"]:
            given, truth = generate.draw(case, seed, work, taxel)
            for entry in entries:
                kept = work / "scores" / given.name / f"{entry['name']}.json"
                if fresh or not kept.exists():
                    figures = run_entry(entry, given.resolve(), truth, work.resolve(), taxel)
                    kept.parent.mkdir(parents=True, exist_ok=True)
                    kept.write_text(json.dumps(figures))
                figures = json.loads(kept.read_text())
                found.append({"case": case["name"], "seed": seed, "entry": entry["name"], **figures})
                print(report.line(found[-1]), flush=True)
    return found


def arguments():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--taxel", default="taxel", help="the program")
    words.add_argument("--work", default="ghosting-work", type=Path, help="where cases, answers and scores go")
    words.add_argument("--cases", default=HERE / "cases.toml", help="the list of cases")
    words.add_argument("--only", nargs="*", help="names of cases")
    words.add_argument("--entries", nargs="*", help="names of entries")
    words.add_argument("--add", nargs="*", default=[], help="more lists of entries, as entries.toml")
    words.add_argument("--fresh", action="store_true", help="take no score from before")
    words.add_argument("--quick", action="store_true", help="one small case, one seed, three entries")
    words.add_argument("--write", action="store_true", help="write docs/ghosting.md and bench/runs/DATE-ghosting.csv")
    return words.parse_args()


def chosen(items, names, what):
    unknown = set(names or []) - {item["name"] for item in items}
    if unknown:
        known = ", ".join(item["name"] for item in items)
        raise SystemExit(f"run.py: no {what} is called {', '.join(sorted(unknown))}\nhint: there are {known}")
    return [item for item in items if not names or item["name"] in names]


def main():
    given = arguments()
    cases, entries = generate.cases_of(given.cases), entries_of([HERE / "entries.toml", *given.add])
    if given.quick:
        cases = [{**case, "seeds": case["seeds"][:1]} for case in chosen(cases, [QUICK["case"]], "case")]
        entries = chosen(entries, given.entries or QUICK["entries"], "entry")
    else:
        cases, entries = chosen(cases, given.only, "case"), chosen(entries, given.entries, "entry")
    if given.write and (given.quick or given.only or given.entries):
        raise SystemExit("run.py: --write wants all cases and entries\nhint: leave --quick, --only and --entries out")
    taxel = shutil.which(given.taxel)
    if taxel is None:
        raise SystemExit(f"run.py: there is no program {given.taxel}\nhint: cargo build --release, then --taxel target/release/taxel")
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    found = run_all(cases, entries, given.work, str(Path(taxel).resolve()), given.fresh)
    if given.write:
        report.write(found, cases, entries, HERE.parent.parent)
    else:
        print("\n" + report.tables(found, cases, entries))


if __name__ == "__main__":
    try:
        main()
    except (generate.Simulation, OSError) as error:
        sys.exit(f"run.py: {error}")
