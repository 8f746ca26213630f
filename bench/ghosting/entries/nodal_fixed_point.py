"""A fixed point on the nodal equations, of any linear read-out: not of a paper, see README.md.

With the potentials of all columns by the conductances of the round before, Kirchhoff's law at the selected row gives the
taxel: G = (I − Σ other taxels' currents) / (V_column − V_row), V_row = I · R_end measured.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
from circuit import Circuit
from solved import run

from case import decline, folders_of_arguments, read_case

ROUNDS = 60
CLOSE = 1e-5  # of the largest conductance: a third of what three counts of 16 bits are


def kirchhoff(siemens, amperes, row_volts, column_volts):
    """Each taxel from the current that its row does not get from others; never less than nothing."""
    own = column_volts[:, np.arange(siemens.shape[1]), np.arange(siemens.shape[1])]
    across_own = own - row_volts
    in_all = np.einsum("rk,rck->rc", siemens, column_volts) - row_volts * siemens.sum(1, keepdims=True)
    sneaking = in_all - siemens * across_own
    good = across_own > 1e-6 * np.abs(column_volts).max()
    found = np.where(good, (amperes - sneaking) / np.where(good, across_own, 1.0), siemens)
    return np.maximum(found, 0.0)


def solver(circuit, rounds=ROUNDS):
    """Rounds whose currents are farther from those read than the best so far are taken back, and the step halved; then it grows again."""

    def solve(counts):
        amperes = circuit.amperes_from_counts(counts)
        measured_volts = amperes * circuit.row_ohms[:, None]
        tried = best = np.maximum(circuit.siemens_alone(amperes), 0.0)
        least, towards, share = np.inf, best, 1.0
        for _ in range(rounds):
            row_volts, column_volts = circuit.potentials(tried)
            misfit = np.abs(row_volts - measured_volts).sum()
            if misfit < least:
                best, least, share = tried, misfit, min(1.5 * share, 1.0)
                towards = kirchhoff(tried, amperes, measured_volts, column_volts)
            else:
                share /= 2
            if share * np.abs(towards - best).max() < CLOSE * best.max():
                break
            tried = best + share * (towards - best)
        return best

    return solve


def main():
    folder, out = folders_of_arguments()
    case = read_case(folder)
    try:
        circuit = Circuit(case.sensor)
    except ValueError as error:
        decline(str(error))
    run(case, out, solver(circuit))


if __name__ == "__main__":
    main()
