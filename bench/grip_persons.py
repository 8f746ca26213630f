"""Simulated persons through whole grip sessions: what `taxel grip` says against what was truly pressed.

    python3 bench/grip_persons.py target/release/taxel --source sim:truth.toml?grip --sensor calibrated.toml --folder grips

The address names the sensor that is gripped, --sensor what is known of it.

Every person is a seed, every session the real program, operated in its terminal mode. Prints bias, limits of agreement and the
coverage of the 95 % intervals of the largest force, and what `taxel grip compare` makes of the sessions. Needs Python 3.10 and
nothing else; about 30 s a session, two at a time.
"""

import argparse
import concurrent.futures
import json
import pathlib
import statistics
import subprocess

PROTOCOL = "trials = {trials}\nhold_secs = 5\nplateau_secs = 3\nrest_secs = 0\ncountdown_secs = 1\n"
ANSWERED = ("Enter takes the zero", "Enter starts it", "Enter accepts it")


def session(given, person):
    """One session of one person, from the zero to the page."""
    separator = "&" if "?" in given.source else "?"
    words = [given.taxel, "grip", f"{given.source}{separator}seed={person}", "--person", f"P{person:02}", "--terminal"]
    words += ["--protocol", given.folder / "protocol.toml", "--folder", given.folder]
    words += ["--sensor", given.sensor] if given.sensor else []
    program = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1)
    said = []
    for line in program.stderr:
        said.append(line)
        if any(words in line for words in ANSWERED):
            program.stdin.write("\n")
            program.stdin.flush()
    if program.wait() != 0:
        raise SystemExit(f"P{person:02}: exit code {program.returncode}\n{''.join(said)}")
    print(f"P{person:02} done", flush=True)


def trials(folder):
    """Every trial of every session: what was said of its largest force, half its interval, and the truth, newtons."""
    for file in sorted(folder.glob("*/*/results.json")):
        for hand in json.loads(file.read_text())["hands"]:
            for trial in hand["trials"]:
                largest = trial["max"]
                yield largest["newtons"], largest["half_width_95_newtons"], trial["true_max_newtons"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taxel", type=pathlib.Path)
    parser.add_argument("--source", default="sim:econe?grip")
    parser.add_argument("--sensor", type=pathlib.Path)
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("grips"))
    parser.add_argument("--persons", type=int, default=20)
    parser.add_argument("--sessions", type=int, default=1)
    parser.add_argument("--trials", type=int, default=1, help="of each hand")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    (given.folder / "protocol.toml").write_text(PROTOCOL.format(trials=given.trials))
    for _ in range(given.sessions):
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            list(pool.map(lambda person: session(given, person), range(1, given.persons + 1)))
    rows = list(trials(given.folder))
    errors = [said - truth for said, _, truth in rows]
    bias, spread = statistics.mean(errors), statistics.stdev(errors)
    held = sum(abs(said - truth) <= half for said, half, truth in rows if half is not None)
    told = sum(half is not None for _, half, _ in rows)
    halves = [half for _, half, _ in rows if half is not None]
    print(f"{len(rows)} trials of {given.persons} persons, true largest force {min(t for *_, t in rows):.1f} to {max(t for *_, t in rows):.1f} N")
    print(f"bias {bias:+.3f} N, limits of agreement {bias - 1.96 * spread:+.3f} to {bias + 1.96 * spread:+.3f} N")
    print(f"{held} of {told} intervals hold the truth; half of one is {statistics.median(halves):.3f} N in the middle")
    if given.sessions > 1:
        subprocess.run([given.taxel, "grip", "compare", given.folder], check=True)


main()
