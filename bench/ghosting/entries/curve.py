"""One calibration curve for the array: a power law from reading to load. No circuit."""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from law import PowerLaw

from case import folders_of_arguments, read_case, write_answer


def main():
    folder, out = folders_of_arguments()
    case = read_case(folder)
    start = time.perf_counter()
    law = PowerLaw(case.at_presses(case.press_frames), case.press_loads_g, case.empty_frames)
    fitted = time.perf_counter()
    loads = law.grams(case.counts)
    seconds = time.perf_counter() - fitted
    write_answer(out, loads, 1000 * seconds / len(case.counts), fitted - start)


if __name__ == "__main__":
    main()
