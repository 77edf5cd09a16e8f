#!/usr/bin/env bash
# ONNX Runtime 1.32.0, 2026-11-30 (x86-64).
# One would guess: session.set_denormal_as_zero is a setting of a session and of the runtime's own threads; the thread that
# makes the session keeps its floating-point state.
# What is so: the first session of the process sets the *calling* thread's flush-to-zero to its own setting, and clears it where
# the host had it on (audio and control code do); later sessions do not touch it, whatever they ask for.
# Why it matters: loading a network changes the bits of everything that the host and the planner compute afterwards on that
# thread, and whether it does depends on who came first. Save and restore the state round every call.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check onnxruntime==1.32.0 onnx==1.23.2 numpy
cd "$folder"
venv/bin/python - <<'PYTHON'
import subprocess
import sys
import textwrap

open("state.c", "w").write("#include <xmmintrin.h>\nunsigned get(void) { return _mm_getcsr() & 0x8040; }\n"
                           "void set(unsigned on) { _mm_setcsr((_mm_getcsr() & ~0x8040u) | (on ? 0x8040u : 0)); }\n")
subprocess.run(["cc", "-O1", "-shared", "-fPIC", "state.c", "-o", "state.so"], check=True)

def child(host, first):
    code = f"""
import ctypes, onnxruntime
from onnx import TensorProto, helper
value = [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n"]) for name in "xy"]
model = helper.make_model(helper.make_graph([helper.make_node("Relu", ["x"], ["y"])], "g", value[:1], value[1:]),
                          opset_imports=[helper.make_opsetid("", 21)], ir_version=10).SerializeToString()
def session(zero):
    options = onnxruntime.SessionOptions()
    options.add_session_config_entry("session.set_denormal_as_zero", zero)
    return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
state = ctypes.CDLL("./state.so")
state.set({host})
session("{first}")
after_first = state.get() != 0
state.set(0)
session("1")
print(onnxruntime.__version__, int(after_first), int(state.get() != 0))
"""
    out = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], check=True, capture_output=True, text=True)
    version, after_first, after_second = out.stdout.split()
    print(f"onnxruntime {version}: host flush-to-zero {host}, first session asks for {first}: after it {after_first}; "
          f"host 0, second session asks for 1: after it {after_second}")
    return int(after_first), int(after_second)

seen = {(host, first): child(host, first) for host in (0, 1) for first in (0, 1)}
raise SystemExit(not all(after == first and later == 0 for (_, first), (after, later) in seen.items()))
PYTHON
