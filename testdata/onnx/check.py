"""Makes the networks that the tests import, and checks what we export against onnxruntime.

    pip install numpy scikit-learn skl2onnx torch onnxscript onnxruntime
    python testdata/onnx/check.py

Small networks by scikit-learn (a pipeline with its StandardScaler) and PyTorch, their inputs, and onnxruntime's answers
go beside this file; crates/taxel-learn/tests/onnx.rs compares our import with them.
"""

import subprocess
import tempfile
import warnings
from pathlib import Path

import numpy as np
import onnxruntime

warnings.filterwarnings("ignore")
here = Path(__file__).parent
rng = np.random.default_rng(1)
X = (30 + 20000 * rng.random((40, 9))).astype(np.float32)
y = (X[:, 0] / 100 - X[:, 1:].sum(1) / 2000).astype(np.float32)


def answers(file, inputs):
    session = onnxruntime.InferenceSession(str(file))
    return session.run(None, {session.get_inputs()[0].name: inputs})[0].astype(np.float32)


def keep(name):
    outputs = answers(here / f"{name}.onnx", X)
    np.savetxt(here / f"{name}.csv", np.c_[X, outputs.reshape(-1)], delimiter=",", fmt="%.9g")


def sklearn_network():
    from skl2onnx import to_onnx
    from sklearn.neural_network import MLPRegressor
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    network = MLPRegressor(hidden_layer_sizes=(7, 5), max_iter=300, random_state=1)
    network = make_pipeline(StandardScaler(), network).fit(X, y)
    (here / "sklearn.onnx").write_bytes(to_onnx(network, X[:1]).SerializeToString())


def torch_network():
    import torch

    torch.manual_seed(1)
    layers = torch.nn.Sequential(
        torch.nn.Linear(9, 7), torch.nn.ReLU(), torch.nn.Linear(7, 5), torch.nn.ReLU(), torch.nn.Linear(5, 1)
    )
    torch.onnx.export(
        layers, (torch.tensor(X),), str(here / "torch.onnx"), external_data=False, dynamic_axes={"x": {0: "n"}},
        input_names=["x"], dynamo=False,
    )


sklearn_network()
keep("sklearn")
torch_network()
keep("torch")

with tempfile.TemporaryDirectory() as folder:
    subprocess.run(
        ["cargo", "run", "--release", "-q", "-p", "taxel-learn", "--example", "export_onnx", "--", folder],
        check=True, cwd=here.parent.parent,
    )
    inputs = np.fromfile(f"{folder}/inputs.f32", np.float32).reshape(-1, 129)
    ours = np.fromfile(f"{folder}/outputs.f32", np.float32)
    theirs = answers(f"{folder}/ours.onnx", inputs).reshape(-1)
    error = np.abs(ours - theirs).max() / np.abs(ours).max()
    print(f"export against onnxruntime: largest difference {error:.1e} of the largest output")
    assert error < 1e-5
