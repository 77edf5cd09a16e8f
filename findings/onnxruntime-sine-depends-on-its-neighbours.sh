#!/usr/bin/env bash
# ONNX Runtime 1.32.0, 2026-11-30 (x86-64 with AVX2 or AVX-512, one thread).
# One would guess: an element-wise operator gives an element the same bits whatever stands beside it, on one machine and
# one thread; if any depends on the batch it is MatMul.
# What is so: Sin, Cos, Log, Asin and Atan give other last bits to the elements at the end of a tensor whose length does not
# fill the vector registers. Exp, Tanh, Sigmoid, Erf and Sqrt do not.
# Why it matters: a network with headings in it (sine and cosine of an angle) gives one candidate action another score
# alone than in a batch, so the same seed gives another plan when batches are cut differently. Compute such
# features outside, or pad every batch to one size.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check onnxruntime==1.32.0 onnx==1.23.2 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import numpy as np
import onnxruntime
from onnx import TensorProto, helper

options = onnxruntime.SessionOptions()
options.intra_op_num_threads = 1
whole = np.random.default_rng(0).uniform(0.05, 0.95, 512).astype(np.float32)

def other_bits(op):
    """Lengths of a first part of the tensor in which an element has other bits than in the whole."""
    value = [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n"]) for name in "xy"]
    graph = helper.make_graph([helper.make_node(op, ["x"], ["y"])], "g", value[:1], value[1:])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 21)], ir_version=10)
    session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
    run = lambda x: session.run(None, {"x": x})[0].view(np.int32)
    all_of_it = run(whole)
    return sum(bool((run(whole[:n]) != all_of_it[:n]).any()) for n in range(1, 256))

counts = {op: other_bits(op) for op in ("Sin", "Cos", "Log", "Asin", "Atan", "Exp", "Tanh", "Sigmoid", "Erf", "Sqrt")}
print(f"onnxruntime {onnxruntime.__version__}: of 255 lengths, those in which some element has other bits: {counts}")
raise SystemExit(not (all(counts[op] > 0 for op in ("Sin", "Cos", "Atan"))
                      and all(counts[op] == 0 for op in ("Exp", "Tanh", "Sigmoid", "Erf", "Sqrt"))))
PYTHON
