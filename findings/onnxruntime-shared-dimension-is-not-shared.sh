#!/usr/bin/env bash
# ONNX Runtime 1.32.0, 2026-11-30.
# One would guess: two inputs whose first dimension has one name ("batch") must agree, and an output declared [1, 2] has
# that shape or the run fails.
# What is so: inputs of 2 and 3 rows under one name are accepted and computed, and an output declared [1, 2] comes back
# as [3, 2] with a warning in the log and status OK.
# Why it matters: code that sizes buffers by the declared shapes, or pairs rows of two inputs (state and action), reads the
# wrong row. Check the shapes of what comes back, every time.
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

onnxruntime.set_default_logger_severity(3)
value = helper.make_tensor_value_info

def session(nodes, inputs, output):
    model = helper.make_model(helper.make_graph(nodes, "g", inputs, [output]),
                              opset_imports=[helper.make_opsetid("", 21)], ir_version=10)
    return onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])

both = session([helper.make_node("ReduceSum", ["a"], ["s"], keepdims=0),
                helper.make_node("ReduceSum", ["b"], ["t"], keepdims=0), helper.make_node("Add", ["s", "t"], ["y"])],
               [value("a", TensorProto.FLOAT, ["batch", 2]), value("b", TensorProto.FLOAT, ["batch", 2])],
               value("y", TensorProto.FLOAT, []))
total = float(both.run(None, {"a": np.ones((2, 2), np.float32), "b": np.ones((3, 2), np.float32)})[0])
one = session([helper.make_node("Identity", ["x"], ["y"])], [value("x", TensorProto.FLOAT, ["n", 2])],
              value("y", TensorProto.FLOAT, [1, 2]))
shape = one.run(None, {"x": np.zeros((3, 2), np.float32)})[0].shape
print(f"onnxruntime {onnxruntime.__version__}: 2 and 3 rows under one name give {total} and no error; "
      f"an output declared {one.get_outputs()[0].shape} has shape {shape}")
raise SystemExit(not (total == 10.0 and shape == (3, 2)))
PYTHON
