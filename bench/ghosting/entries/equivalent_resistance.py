"""Resistances of all cells from the equivalent resistances between rows and columns, after Medrano-Sánchez and others (2019).

IEEE Sensors Journal 2019, doi:10.1109/JSEN.2019.2918592. Its abstract poses the problem and names the ways it compares; the
equations here are ours. R_eq = (e_r − e_c)ᵀ L⁺ (e_r − e_c), L the Laplacian of the network of taxels. Two ways:

    --way fixed-point     G ← G · R_eq(G)/R_measured. Of ln G the step is I − J, J = −∂ln R_eq/∂ln G with eigenvalues from 0 to
                          1, so that it never diverges near the answer; it is slow where J is small
    --way least-squares   ln R_eq(G) to ln R_measured over ln G, Levenberg–Marquardt with the exact derivative
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np
from circuit import Circuit
from solved import run

from case import decline, folders_of_arguments, read_case

LEAST_SIEMENS = 1e-8
FIXED_POINT_ROUNDS, FIXED_POINT_CLOSE = 500, 1e-6
NEWTON_ROUNDS, NEWTON_CLOSE = 30, 1e-7
LARGEST = 256  # taxels: the derivative is a full matrix, and no larger array was published


def grounded_inverse(siemens):
    """L⁺ up to what no difference sees."""
    rows, columns = siemens.shape
    laplacian = np.zeros((rows + columns,) * 2)
    laplacian[:rows, rows:], laplacian[rows:, :rows] = -siemens, -siemens.T
    laplacian[np.diag_indices_from(laplacian)] = np.concatenate([siemens.sum(1), siemens.sum(0)])
    return np.linalg.inv(laplacian + siemens.mean() / len(laplacian))


def equivalent_ohms(inverse, rows):
    diagonal = np.diag(inverse)
    return diagonal[:rows, None] + diagonal[None, rows:] - 2 * inverse[:rows, rows:]


def derivative(inverse, rows):
    """∂R_eq(taxel i)/∂G(taxel k) = −(what one ampere through i puts across k)²."""
    taxels = [(r, rows + c) for r in range(rows) for c in range(len(inverse) - rows)]
    row, column = np.array(taxels).T
    across = inverse[np.ix_(row, row)] + inverse[np.ix_(column, column)]
    across -= inverse[np.ix_(row, column)] + inverse[np.ix_(column, row)]
    return -(across**2)


def fixed_point(measured_ohms):
    siemens = 1 / measured_ohms
    for _ in range(FIXED_POINT_ROUNDS):
        ratio = equivalent_ohms(grounded_inverse(siemens), len(siemens)) / measured_ohms
        siemens = np.maximum(siemens * ratio, LEAST_SIEMENS)
        if np.abs(ratio - 1).max() < FIXED_POINT_CLOSE:
            break
    return siemens


def least_squares(measured_ohms):
    shape = measured_ohms.shape
    target = np.log(measured_ohms)
    logs = -target - np.log(2.0)  # half of what the equivalent says: others are parallel
    damping = 1e-3
    inverse = grounded_inverse(np.exp(logs))
    misfit = np.log(equivalent_ohms(inverse, shape[0])) - target
    for _ in range(NEWTON_ROUNDS):
        jacobian = derivative(inverse, shape[0]) * np.exp(logs).ravel()
        jacobian /= equivalent_ohms(inverse, shape[0]).ravel()[:, None]
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ misfit.ravel()
        while damping < 1e8:
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient).reshape(shape)
            tried = np.maximum(logs - np.clip(step, -3, 3), np.log(LEAST_SIEMENS))
            inverse_tried = grounded_inverse(np.exp(tried))
            misfit_tried = np.log(np.maximum(equivalent_ohms(inverse_tried, shape[0]), 1e-3)) - target
            if (misfit_tried**2).sum() < (misfit**2).sum():
                break
            damping *= 10
        else:
            break
        moved = np.abs(tried - logs).max()
        logs, inverse, misfit, damping = tried, inverse_tried, misfit_tried, damping / 10
        if moved < NEWTON_CLOSE:
            break
    return np.exp(logs)


WAYS = {"fixed-point": fixed_point, "least-squares": least_squares}


def solver(circuit, way):
    """Where nothing is held but the two selected lines, a reading is the equivalent resistance and the series path."""
    least_amperes = 0.25 * circuit.amperes_from_counts(1)  # of a reading of nothing

    def solve(counts):
        amperes = np.maximum(circuit.amperes_from_counts(counts), least_amperes)
        return way(np.maximum(circuit.v_test / amperes - circuit.series_ohms, 1.0))

    return solve


def main():
    folder, out = folders_of_arguments()
    way = WAYS[sys.argv[sys.argv.index("--way") + 1]]
    case = read_case(folder)
    if case.topology != "divider-floating":
        decline("only for divider-floating: elsewhere a reading is no equivalent resistance")
    if case.counts[0].size > LARGEST:
        decline(f"{case.counts[0].size} taxels, at most {LARGEST}")
    run(case, out, solver(Circuit(case.sensor), way))


if __name__ == "__main__":
    main()
