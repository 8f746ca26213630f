"""Self-test of the benchmark: `python3 -m unittest` in this folder, seconds. With TAXEL naming the program, a case is drawn too."""

import os
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "entries")]

import equivalent_resistance
import generate
import nodal_fixed_point
import run
import zero_potential_two_steps
from case import read_case, write_answer
from circuit import Circuit
from law import PowerLaw
from material import siemens_from_grams
from score import Refused, score

NGSPICE = HERE.parent.parent / "testdata" / "ngspice"
SOLVED = ["tia-grounded-columns-8x8-ron5", "tia-zero-potential-8x8-ron10", "divider-grounded-columns-8x8-ron70"]
SOLVED += ["divider-floating-8x8-ron70", "divider-voltage-feedback-8x8-ron70", "divider-floating-12x5"]


def solved(name):
    """A circuit, its conductances, and its readings by ngspice as counts without rounding."""
    folder = NGSPICE / name
    circuit = Circuit(tomllib.loads((folder / "sensor.toml").read_text()))
    siemens = np.loadtxt(folder / "conductance.csv", delimiter=",", ndmin=2)
    volts = np.abs(np.loadtxt(folder / "v_out.csv", delimiter=",", skiprows=1)[:, 2].reshape(siemens.shape))
    largest = 2 ** circuit.converter["bits"] - 1
    return circuit, siemens, volts / circuit.converter["full_scale_volts"] * largest


class Scorer(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.given, self.truth, self.out = (Path(self.folder.name) / name for name in ("case", "truth", "out"))
        for folder in (self.given, self.truth, self.out):
            folder.mkdir()
        self.loads = np.zeros((2, 3, 4))
        self.loads[:, 1:, 1:] = np.arange(1.0, 13.0).reshape(2, 2, 3)
        scored = np.ones((3, 4), bool)
        scored[2] = False
        np.save(self.given / "counts.npy", np.zeros(self.loads.shape, np.uint16))
        np.save(self.truth / "loads.npy", self.loads)
        np.save(self.truth / "conductances.npy", 1e-6 + 1e-6 * self.loads)
        np.save(self.truth / "scored.npy", scored)

    def judged(self, loads, **others):
        write_answer(self.out, loads, 1.0, **others)
        return score(self.given, self.truth, self.out)

    def refused(self, *words):
        with self.assertRaises(Refused) as caught:
            score(self.given, self.truth, self.out)
        for word in (*words, "hint:"):
            self.assertIn(word, str(caught.exception))

    def test_the_truth_has_no_error(self):
        figures = self.judged(self.loads, half_g=np.zeros(self.loads.shape), siemens=1e-6 + 1e-6 * self.loads)
        for figure in ("error_g", "ghost_g", "total_share", "siemens_share"):
            self.assertEqual(figures[figure], 0.0, figure)
        self.assertEqual((figures["coverage"], figures["stated"]), (1.0, 1.0))

    def test_errors_ghosts_and_totals_are_told_apart(self):
        ghost = self.loads.copy()
        ghost[0, 0, 0] = -5.0
        figures = self.judged(ghost)
        self.assertEqual((figures["error_g"], figures["ghost_g"]), (0.0, 5.0))
        figures = self.judged(1.1 * self.loads)
        self.assertAlmostEqual(figures["error_share"], 0.1)
        self.assertAlmostEqual(figures["total_share"], 0.1)
        self.assertEqual(figures["ghost_g"], 0.0)

    def test_lines_that_nobody_can_read_are_not_judged(self):
        wrong = self.loads.copy()
        wrong[:, 2] += 100.0
        self.assertEqual(self.judged(wrong)["error_g"], 0.0)

    def test_an_interval_without_bounds_is_none(self):
        half = np.full(self.loads.shape, np.inf)
        half[0] = 1.0
        figures = self.judged(self.loads + 2.0, half_g=half)
        self.assertEqual((figures["coverage"], figures["stated"]), (0.0, 0.5))

    def test_a_broken_answer_is_told_what_is_wrong(self):
        self.refused("loads.npy", "missing")
        np.save(self.out / "loads.npy", self.loads[:, :, :3])
        self.refused("2 × 3 × 3", "2 × 3 × 4")
        broken = self.loads.copy()
        broken[1, 2, 3] = np.nan
        np.save(self.out / "loads.npy", broken)
        self.refused("1 of 24", "frame 1, row 2, column 3")
        (self.out / "loads.npy").write_text("not an array")
        self.refused("loads.npy is no array")
        np.save(self.out / "loads.npy", self.loads)
        self.refused("timing.json", "missing")
        write_answer(self.out, self.loads, -1.0)
        self.refused("-1", "at least 0")
        write_answer(self.out, self.loads, 1.0, half_g=self.loads - 1)
        self.refused("half.npy", "-1.0 g", "at least 0")


class Entries(unittest.TestCase):
    def test_the_circuit_is_the_one_that_ngspice_solved(self):
        for name in SOLVED:
            circuit, siemens, counts = solved(name)
            amperes = circuit.amperes_from_counts(counts)
            row_volts, _ = circuit.potentials(siemens)
            off = np.abs(row_volts / circuit.row_ohms[:, None] - amperes).max() / amperes.max()
            self.assertLess(off, 3e-8, name)

    def test_solvers_undo_what_ngspice_solved(self):
        for name in SOLVED:
            circuit, siemens, counts = solved(name)
            ways = [(nodal_fixed_point.solver(circuit), 1e-4)]
            if circuit.topology == "divider-floating":
                # Kirchhoff's law at a row that floats: so slow that it is no answer, as the table shows.
                ways.clear()
                ways.append((equivalent_resistance.solver(circuit, equivalent_resistance.fixed_point), 3e-3))
                ways.append((equivalent_resistance.solver(circuit, equivalent_resistance.least_squares), 1e-6))
            if circuit.topology == "tia-zero-potential":
                ways.append((zero_potential_two_steps.solver(circuit), 2e-4))
            for solve, bound in ways:
                off = np.abs(solve(counts) - siemens).max() / siemens.max()
                self.assertLess(off, bound, name)

    def test_two_steps_are_as_far_off_as_the_paper_prints(self):
        """Hidalgo-López and others (2018), Table 2: 8 × 8, one taxel among others of 5 kΩ; errors in %, after no, one and two steps."""
        printed = {
            (25, 100): (58.82, 9.39, 2.12), (25, 500): (17.42, 1.43, 0.14), (25, 2000): (9.61, 0.63, 0.03),
            (9, 100): (20.76, 1.67, 0.17), (9, 500): (6.17, 0.20, 0.00), (15, 100): (34.86, 4.07, 0.63),
        }  # fmt: skip
        for (switch, ohms), errors in printed.items():
            circuit, siemens = zero_potential_of(switch), np.full((8, 8), 1 / 5000)
            siemens[0, 0] = 1 / ohms
            amperes = circuit.potentials(siemens)[0] / circuit.row_ohms[:, None]
            found = amperes / circuit.v_test
            for error in errors:
                # The paper's amplifiers are not ideal, which is worth 0.02 % where taxels are of some kΩ.
                self.assertAlmostEqual(100 * (1 / found[0, 0] / ohms - 1), error, delta=0.03)
                found = zero_potential_two_steps.step(circuit, found, amperes)

    def test_the_curve_is_found_whatever_the_labels_of_a_few(self):
        loads = np.linspace(20, 600, 40)
        x = 5.0 + 3.0 * loads**0.8
        labels = loads.copy()
        labels[::10] *= 3
        law = PowerLaw(x, labels, np.full(9, 5.0))
        self.assertLess(np.abs(law.grams(x) / loads - 1).max(), 0.02)


def zero_potential_of(switch_ohms):
    readout = {"topology": "tia-zero-potential", "v_test_volts": 1.0, "r_feedback_ohms": 1000.0, "open_loop_gain": 1e12}
    readout |= {"r_mux_column_ohms": switch_ohms, "r_mux_row_ohms": switch_ohms}
    converter = {"bits": 16, "full_scale_volts": 1.0}
    return Circuit({"array": {"rows": 8, "columns": 8}, "readout": readout, "converter": converter})


class Truth(unittest.TestCase):
    def test_spread_gives_to_neighbours_what_it_takes(self):
        loads = np.zeros((1, 5, 6))
        loads[0, 2, 3] = 100.0
        material = {"factor": 1.0, "exponent": 1.0, "spread": [0.05, 0.04, 0.01]}
        felt = siemens_from_grams(loads, material)[0]
        self.assertAlmostEqual(felt.sum(), 100.0)
        self.assertAlmostEqual(felt[2, 3], 78.0)
        self.assertAlmostEqual(felt[1, 3], 5.0)
        self.assertAlmostEqual(felt[2, 2], 4.0)
        self.assertAlmostEqual(felt[3, 4], 1.0)

    def test_cases_have_names_of_their_own_and_sizes_and_read_outs_are_all_there(self):
        cases = generate.cases_of(HERE / "cases.toml")
        self.assertEqual(len({case["name"] for case in cases}), len(cases))
        self.assertEqual(len({case["topology"] for case in cases}), 6)
        self.assertTrue({(8, 8), (64, 128)} <= {tuple(case["size"]) for case in cases})
        self.assertTrue(all(len(set(case["seeds"])) == 3 for case in cases))


@unittest.skipUnless(os.environ.get("TAXEL"), "TAXEL does not name the program")
class Drawn(unittest.TestCase):
    def test_a_drawn_case_is_what_it_says(self):
        taxel = os.environ["TAXEL"]
        # A plain case, one with all that [material] says of a moment, and one whose material remembers.
        for name in ("ideal-8x8-grounded", "beyond-16x16-divider", "creep-16x16-grounded"):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                (case,) = (x for x in generate.cases_of(HERE / "cases.toml") if x["name"] == name)
                given, truth = generate.draw(case, case["seeds"][0], folder, taxel)
                self.assertNotIn("material", read_case(given).sensor)
                self.scanned(taxel, given, truth, Path(folder))
                self.no_frame_twice(read_case(given))
                if name.startswith("ideal"):
                    self.entries_are_run(given, truth, Path(folder))

    def scanned(self, taxel, given, truth, folder):
        """The program's exact scan of the true conductances is what the counts say, but for noise and carry-over."""
        words = ["--sensor", truth / "sensor.toml", "--conductance", truth / "conductances.npy", "--unit", "counts"]
        subprocess.run([taxel, "simulate", *words, "-o", folder / "exact.npy"], check=True, capture_output=True)
        counts = np.load(given / "counts.npy").astype(float)
        off = np.abs(np.load(folder / "exact.npy") - counts)
        self.assertLess(np.median(off), 4.0)
        self.assertLess(off.max(), 20.0 + 0.01 * counts.max())

    def no_frame_twice(self, case):
        frames = np.concatenate([case.counts, case.press_frames, case.uniform_frames, case.empty_frames])
        self.assertEqual(len(np.unique(frames.reshape(len(frames), -1), axis=0)), len(frames))

    def entries_are_run(self, given, truth, folder):
        wrong = "import numpy, sys; numpy.save(sys.argv[-1] + '/loads.npy', numpy.zeros((1, 2, 3)))"
        ways = {
            "good": [sys.executable, str(HERE / "entries" / "curve.py")],
            "wrong": [sys.executable, "-c", wrong],
            "stops": [sys.executable, "-c", "raise SystemExit('no idea')"],
            "other": [sys.executable, str(HERE / "entries" / "zero_potential_two_steps.py")],
            "none": [str(folder / "not-there")],
        }
        found = {
            name: run.run_entry({"name": name, "command": way}, given.resolve(), truth, folder, os.environ["TAXEL"])
            for name, way in ways.items()
        }
        self.assertLess(found["good"]["error_share"], 1.0)
        self.assertIn("1 × 2 × 3, expected 12 × 8 × 8", found["wrong"]["failed"])
        self.assertEqual(found["stops"]["failed"], "no idea")
        self.assertIn("tia-zero-potential", found["other"]["declined"])
        self.assertIn("could not be started", found["none"]["failed"])


if __name__ == "__main__":
    unittest.main()
