"""Two steps of a recursion for the zero-potential read-out, in the manner of Hidalgo-López and others (2018).

J. A. Hidalgo-López, R. Fernández-Ramos, J. Romero-Sánchez, J. F. Martín-Canales, F. J. Ríos-Gómez: Improving Accuracy in the
Readout of Resistive Sensor Arrays. Journal of Sensors 2018, 9735741. doi:10.1155/2018/9735741

Derived by us from what the paper says of it; its equations were not at hand. test_ghosting.py holds both steps against the
errors that its Table 2 prints. With every row held through R, a reading tells the row's potential, v = I · R. Kirchhoff's law
at each column then tells the column's, with the conductances of the step before, and the law at the row tells the taxel.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
from circuit import Circuit
from nodal_fixed_point import kirchhoff
from solved import run

from case import decline, folders_of_arguments, read_case

STEPS = 2


def step(circuit, siemens, amperes):
    """One step: better conductances from the last ones and the readings."""
    row_volts = amperes * circuit.row_ohms[:, None]  # [r, c]: row r while column c is driven
    ends = np.where(np.eye(circuit.columns, dtype=bool), circuit.column_selected, circuit.column_unselected[:, None])
    driven = np.diag(circuit.column_selected * circuit.v_test)
    columns = (driven + siemens.T @ row_volts) / (ends + siemens.sum(0)[:, None])  # [k, c]
    column_volts = np.broadcast_to(columns.T, (circuit.rows, *columns.shape))
    return kirchhoff(siemens, amperes, row_volts, column_volts)


def solver(circuit, steps=STEPS):
    def solve(counts):
        amperes = circuit.amperes_from_counts(counts)
        siemens = np.maximum(amperes / circuit.v_test, 0.0)
        for _ in range(steps):
            siemens = step(circuit, siemens, amperes)
        return siemens

    return solve


def main():
    folder, out = folders_of_arguments()
    case = read_case(folder)
    if case.topology != "tia-zero-potential":
        decline("only for tia-zero-potential: what it is derived from needs every row's potential to be read")
    run(case, out, solver(Circuit(case.sensor)))


if __name__ == "__main__":
    main()
