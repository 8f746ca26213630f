"""The paper's network trained by this project, scikit-learn and PyTorch: the same start, the same batches, one thread.

    pip install scikit-learn torch
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python bench/train.py ROWS.csv COLUMNS COPIES EPOCHS FOLDER

Prints seconds an epoch and the loss after every epoch. The losses of scikit-learn must follow ours to 1e-3.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

rows, columns, copies, epochs, folder = sys.argv[1:6]
epochs, folder = int(epochs), Path(folder)
subprocess.run(
    ["cargo", "run", "--release", "-q", "-p", "taxel-learn", "--example", "train_paper_mlp", "--", *sys.argv[1:6]],
    check=True,
    cwd=Path(__file__).parent.parent,
)
widths = [int(columns) + 1, 160, 480, 240, 1]
X = np.fromfile(folder / "inputs.f32", np.float32).reshape(-1, widths[0])
y = np.fromfile(folder / "loads.f32", np.float32)
orders = np.fromfile(folder / "orders.u32", np.uint32).reshape(epochs, len(y))
flat = np.fromfile(folder / "weights.f32", np.float32)
ours = np.loadtxt(folder / "losses.txt", ndmin=2)
weights, biases, at = [], [], 0
for a, b in zip(widths, widths[1:]):
    weights.append(flat[at : at + a * b].reshape(a, b).copy())
    biases.append(flat[at + a * b : at + a * b + b].copy())
    at += (a + 1) * b


def sklearn_epochs(dtype):
    from sklearn.neural_network import MLPRegressor

    network = MLPRegressor(hidden_layer_sizes=tuple(widths[1:-1]), batch_size=200, shuffle=False)
    network.partial_fit(X[:200].astype(dtype), y[:200].astype(dtype))
    network.coefs_ = [w.astype(dtype) for w in weights]
    network.intercepts_ = [b.astype(dtype) for b in biases]
    del network._optimizer
    found = []
    for order in orders:
        inputs, loads = X[order].astype(dtype), y[order].astype(dtype)
        begun = time.perf_counter()
        network.partial_fit(inputs, loads)
        found.append((network.loss_, time.perf_counter() - begun))
    return np.array(found), network


def torch_epochs():
    import torch

    torch.set_num_threads(1)
    layers = []
    for i, (w, b) in enumerate(zip(weights, biases)):
        layer = torch.nn.Linear(*w.shape)
        layer.weight.data = torch.tensor(w.T.copy())
        layer.bias.data = torch.tensor(b)
        layers += [layer] + ([torch.nn.ReLU()] if i < len(weights) - 1 else [])
    network = torch.nn.Sequential(*layers)
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-3)
    inputs, loads = torch.tensor(X), torch.tensor(y)[:, None]
    found = []
    for order in orders:
        order = torch.tensor(order.astype(np.int64))
        begun, total = time.perf_counter(), 0.0
        for batch in order.split(200):
            optimiser.zero_grad()
            loss = 0.5 * torch.nn.functional.mse_loss(network(inputs[batch]), loads[batch])
            loss.backward()
            optimiser.step()
            total += loss.item() * len(batch)
        found.append((total / len(y), time.perf_counter() - begun))
    return np.array(found)


def report(name, found):
    difference = np.abs(found[:, 0] / ours[:, 0] - 1)
    print(
        f"{name:24} {np.median(found[:, 1]):6.2f} s an epoch, {np.median(found[:, 1]) / np.median(ours[:, 1]):5.2f} of ours; "
        f"loss {found[-1, 0]:.4f}; relative difference of the loss by epoch "
        + " ".join(f"{d:.0e}" for d in difference)
    )


print(f"{len(y)} rows, {epochs} epochs, batch 200, {'-'.join(map(str, widths))}")
report("ours", ours)
found, network = sklearn_epochs(np.float64)
report("scikit-learn (f64)", found)
report("scikit-learn (f32)", sklearn_epochs(np.float32)[0])
report("PyTorch", torch_epochs())

# As many taxels as a gripped array has pressed, from the frame's counts to loads: inputs put together, standardised,
# predicted. The example above does the same.
from sklearn.preprocessing import StandardScaler

scaler = StandardScaler().fit(X)
frame = (1000 * np.abs(X[:64, 1:])).astype(np.float64)
pressed = [(i // 32, i % 32) for i in range(2000)]
whole, alone = [], []
for _ in range(30):
    begun = time.perf_counter()
    r, c = np.array(pressed).T
    inputs = scaler.transform(np.concatenate([frame[r, c][:, None], frame[r]], axis=1))
    ready = time.perf_counter()
    network.predict(inputs)
    whole.append(time.perf_counter() - begun)
    alone.append(time.perf_counter() - ready)
print(
    f"scikit-learn, a frame with {len(pressed)} taxels pressed: {1e3 * np.median(whole):.2f} ms, "
    f"{1e3 * np.median(alone):.2f} ms of it predict (f64, its default)"
)
