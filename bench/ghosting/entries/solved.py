"""What all entries share that turn counts into conductances and know nothing of the law: solve, fit one law, write."""

import time

import numpy as np
from law import PowerLaw

from case import write_answer


def run(case, out, solve):
    """`solve` takes a frame of counts to a frame of siemens."""
    start = time.perf_counter()
    presses = case.at_presses(np.array([solve(frame) for frame in case.press_frames]))
    empty = np.array([solve(frame) for frame in case.empty_frames])
    law = PowerLaw(presses, case.press_loads_g, empty)
    fitted = time.perf_counter()
    siemens = np.array([solve(frame) for frame in case.counts])
    loads = law.grams(siemens)
    seconds = time.perf_counter() - fitted
    write_answer(out, loads, 1000 * seconds / len(case.counts), fitted - start, siemens=siemens)
