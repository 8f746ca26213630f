"""Judges an answer by the truth.

    python3 score.py CASE_DIR TRUTH_DIR OUT_DIR

Prints one JSON object. An answer that breaks the contract is refused with what is wrong, both numbers and a hint (exit
code 1). Figures, each over all frames of the case and the taxels of whole lines:

    error_g        mean |load − truth| of loaded taxels, grams
    error_share    the same as a share of their mean load
    ghost_g        largest |load| of an unloaded taxel, grams; ghost_99_g: 99 % of them are below
    total_share    mean over frames of |Σ load − Σ truth| / Σ truth
    coverage       share of loaded taxels with |load − truth| ≤ half, of those whose half-width is finite
    stated         share of loaded taxels whose half-width is finite
    half_g         median finite half-width of loaded taxels
    siemens_share  mean relative error of the conductances of loaded taxels, where siemens.npy is there
    ms_per_frame, setup_s   what the entry told
"""

import json
import sys
from pathlib import Path

import numpy as np


class Refused(ValueError):
    """An answer that breaks the contract."""

    def __init__(self, what, hint):
        super().__init__(f"{what}\nhint: {hint}")


def score(given, truth, out):
    """The figures of an answer; raises Refused where it is none."""
    shape = np.load(Path(given) / "counts.npy", mmap_mode="r").shape
    loads = read(out, "loads.npy", shape, "loads in grams, one for each count of counts.npy")
    half = read(out, "half.npy", shape, "half of each 95 % interval, grams; inf where nothing is stated", may_be_inf=True)
    siemens = read(out, "siemens.npy", shape, "conductances in siemens")
    if loads is None:
        raise Refused(f"{Path(out) / 'loads.npy'} is missing", "write loads in grams, frames × rows × columns")
    true_loads = np.load(Path(truth) / "loads.npy")
    scored = np.broadcast_to(np.load(Path(truth) / "scored.npy"), shape)
    figures = judge(loads, true_loads, scored)
    loaded = scored & (true_loads > 0)
    if half is not None:
        figures |= judge_intervals(loads[loaded], true_loads[loaded], half[loaded])
    if siemens is not None:
        true_siemens = np.load(Path(truth) / "conductances.npy")[loaded]
        figures["siemens_share"] = float(np.mean(np.abs(siemens[loaded] / true_siemens - 1)))
    return figures | timing(out)


def judge(loads, truth, scored):
    loaded, unloaded = scored & (truth > 0), scored & (truth == 0)
    errors = np.abs(loads - truth)
    ghosts = np.abs(loads[unloaded])
    sums, true_sums = (np.where(scored, values, 0).sum((1, 2)) for values in (loads, truth))
    known = true_sums > 0
    return {
        "loaded": int(loaded.sum()),
        "mean_load_g": float(truth[loaded].mean()),
        "error_g": float(errors[loaded].mean()),
        "error_share": float(errors[loaded].mean() / truth[loaded].mean()),
        "ghost_g": float(ghosts.max(initial=0.0)),
        "ghost_99_g": float(np.quantile(ghosts, 0.99)) if ghosts.size else 0.0,
        "total_share": float(np.mean(np.abs(sums[known] / true_sums[known] - 1))),
    }


def judge_intervals(loads, truth, half):
    stated = np.isfinite(half)
    inside = np.abs(loads - truth)[stated] <= half[stated]
    return {
        "stated": float(stated.mean()),
        "coverage": float(inside.mean()) if stated.any() else None,
        "half_g": float(np.median(half[stated])) if stated.any() else None,
    }


def read(out, name, shape, what, may_be_inf=False):
    """An array of the answer, or None where there is no such file."""
    file = Path(out) / name
    if not file.exists():
        return None
    try:
        values = np.load(file)
    except (ValueError, EOFError, OSError) as error:
        raise Refused(f"{file} is no array: {error}", f"numpy.save writes one; {what}") from error
    if not np.issubdtype(values.dtype, np.number) or np.iscomplexobj(values):
        raise Refused(f"{file} holds {values.dtype}, expected real numbers", what)
    if values.shape != shape:
        raise Refused(f"{file} is {by(values.shape)}, expected {by(shape)}", f"frames × rows × columns: {what}")
    broken = np.isnan(values) if may_be_inf else ~np.isfinite(values)
    if broken.any():
        at = tuple(int(x) for x in np.argwhere(broken)[0])
        raise Refused(
            f"{file} has {broken.sum()} of {values.size} values that are no numbers, the first at frame {at[0]}, "
            f"row {at[1]}, column {at[2]}",
            "say 0 where nothing is known, and inf in half.npy",
        )
    if may_be_inf and (values < 0).any():
        least = float(values.min())
        raise Refused(f"{file} has a half-width of {least} g, at least 0 expected", what)
    return values.astype(float)


def by(shape):
    return " × ".join(map(str, shape))


def timing(out):
    file = Path(out) / "timing.json"
    if not file.exists():
        raise Refused(f"{file} is missing", 'write {"ms_per_frame": …}, the mean over the test frames')
    try:
        told = json.loads(file.read_text())
        figures = {key: float(told[key]) for key in ("ms_per_frame", "setup_s") if key in told}
    except (ValueError, TypeError) as error:
        raise Refused(f"{file} cannot be read: {error}", 'it holds one object, {"ms_per_frame": …}') from error
    if not figures.get("ms_per_frame", -1) >= 0:
        raise Refused(f"{file}: ms_per_frame is {told.get('ms_per_frame')}, at least 0 expected", "milliseconds a frame")
    return figures


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit("usage: score.py CASE_DIR TRUTH_DIR OUT_DIR")
    try:
        print(json.dumps(score(*sys.argv[1:]), indent=2))
    except Refused as refused:
        sys.exit(f"score.py: {refused}")
