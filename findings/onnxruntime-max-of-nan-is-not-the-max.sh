#!/usr/bin/env bash
# ONNX Runtime 1.32.0, 2026-11-30 (x86-64).
# One would guess: ReduceMax with a NaN among its numbers gives NaN, as NumPy and torch do, or else skips it.
# What is so: it does neither: NaN where it stands first, the right value in some places, and in others a value *below*
# the maximum of the rest (of 0.1, NaN, 0.63, 0.9 the answer is 0.63). ArgMax skips a NaN unless it is first, TopK
# puts it on top, MaxPool skips it: four rules in one runtime.
# Why it matters: a network that scores candidate actions hides a bad score behind a plausible number and picks a worse
# action in silence. Check for NaN before reducing; do not reduce in the graph if inputs may be NaN.
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

def session(op, attributes, output, extra=()):
    graph = helper.make_graph(
        [helper.make_node(op, ["x", *[e.name for e in extra]], ["y", "i"][: len(output)], **attributes)], "g",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n"])], output, list(extra))
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 21)], ir_version=10)
    return onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])

value = helper.make_tensor_value_info
largest = session("ReduceMax", {"keepdims": 0}, [value("y", TensorProto.FLOAT, [])])
place = session("ArgMax", {"axis": 0, "keepdims": 0}, [value("y", TensorProto.INT64, [])])
best = session("TopK", {"axis": 0}, [value("y", TensorProto.FLOAT, [1]), value("i", TensorProto.INT64, [1])],
               [helper.make_tensor("k", TensorProto.INT64, [1], [1])])
below = first = 0
for at in range(4):
    scores = np.linspace(0.1, 0.9, 4).astype(np.float32)
    scores[at] = np.nan
    answer = float(largest.run(None, {"x": scores})[0])
    below += answer < float(np.nanmax(scores)) - 1e-6
    first += at == 0 and np.isnan(answer)
    print(f"onnxruntime {onnxruntime.__version__}: {scores.tolist()}: ReduceMax {answer:.2f}, "
          f"ArgMax {int(place.run(None, {'x': scores})[0])}, TopK {float(best.run(None, {'x': scores})[0][0]):.2f} "
          f"(numpy nanmax {np.nanmax(scores):.2f})")
raise SystemExit(not (below >= 1 and first == 1))
PYTHON
