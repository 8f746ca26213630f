"""The e-Cone paper's network: `taxel train paper-mlp` on the labelled presses, the taxel and its row's readings in.

The paper trains on 1,400 points. Here there are the presses that everybody has, as many shuffled copies as in the paper, and EPOCHS
epochs; it keeps the best of them by presses set aside.
"""

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from taxel_program import compensate, taxel

from case import folders_of_arguments, read_case, write_answer

COPIES, EPOCHS = 100, 40


def main():
    folder, out = folders_of_arguments()
    case = read_case(folder)
    out.mkdir(parents=True, exist_ok=True)
    model = out / "network.safetensors"
    start = time.perf_counter()
    words = ["--sensor", folder / "sensor.toml", "--presses", folder / "presses.csv", "-o", model]
    print(taxel("train", "paper-mlp", *words, "--copies", COPIES, "--epochs", EPOCHS))
    setup_s = time.perf_counter() - start
    loads, half, ms = compensate(case, folder / "sensor.toml", model, out, False)
    write_answer(out, loads, ms, setup_s, half)


if __name__ == "__main__":
    main()
