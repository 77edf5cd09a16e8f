#!/usr/bin/env python3
"""Makes the small networks that the tests load: one of every kind, with weights from a fixed seed and never trained.

    python tests/data/nets/make.py      # needs numpy, onnx and onnxruntime; writes beside itself

They have the tensors, metadata and self-tests that docs/networks.md asks for, and answers of a sensible size: `dipn`
corrects the planar engine's guess by millimetres at most, `dipn_none` does without a guess.
"""

import json
import pathlib

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

HERE = pathlib.Path(__file__).parent
SIDE = 32
WIDTH = 8
OUTPUTS = 8


class Lcg:
    """The stream of the self-test: Knuth's MMIX constants."""

    def __init__(self, seed):
        self.state = seed

    def take(self, count):
        values = np.empty(count, np.float32)
        for i in range(count):
            self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
            values[i] = (self.state >> 40) / 2**24
        return values


class Graph:
    """Nodes and weights as they are written down."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        self.nodes, self.weights, self.count = [], [], 0

    def __call__(self, op, *inputs, out=None, **attributes):
        self.count += 1
        out = out or f"v{self.count}"
        self.nodes.append(helper.make_node(op, list(inputs), [out], **attributes))
        return out

    def constant(self, value):
        self.count += 1
        name = f"w{self.count}"
        self.weights.append(numpy_helper.from_array(np.asarray(value), name))
        return name

    def weight(self, *shape, scale=0.5):
        return self.constant((self.random.standard_normal(shape) * scale).astype(np.float32))

    def linear(self, x, inner, outer):
        return self("Add", self("MatMul", x, self.weight(inner, outer)), self.weight(outer))

    def scaled(self, x, factor):
        return self("Mul", x, self.constant(np.float32(factor)))


def value(name, *dims, dtype=TensorProto.FLOAT):
    return helper.make_tensor_value_info(name, dtype, list(dims))


def objects(g, extra, width):
    """Features of every body with a message of the mean of all, [batch, num_objects, WIDTH]."""
    flat = g("Reshape", "outline", g.constant(np.array([0, 0, 64], np.int64)))
    mask = g("Unsqueeze", "present", g.constant(np.array([2], np.int64)))
    x = g("Concat", flat, "centre", "body", *extra, axis=2)
    push = g("Unsqueeze", g.linear("push", 4, WIDTH), g.constant(np.array([1], np.int64)))
    x = g("Tanh", g("Add", g.linear(x, width, WIDTH), push))
    x = g("Mul", x, mask)
    axis = g.constant(np.array([1], np.int64))
    total = g("ReduceSum", x, axis, keepdims=1)
    number = g("ReduceSum", mask, axis, keepdims=1)
    mean = g("Div", total, g("Add", number, g.constant(np.float32(1e-6))))
    return g("Tanh", g("Add", g.linear(x, WIDTH, WIDTH), g.linear(mean, WIDTH, WIDTH))), mask


OBJECTS = [
    value("outline", "batch", "num_objects", 32, 2),
    value("centre", "batch", "num_objects", 2),
    value("body", "batch", "num_objects", 4),
    value("push", "batch", 4),
]
GUESS = value("guess", "batch", "num_objects", 3)
PRESENT = value("present", "batch", "num_objects")
TARGET = value("target", "batch", "num_objects")
MOTION = value("motion", "batch", "num_objects", 3)


def dipn(guess):
    g = Graph(1)
    x, mask = objects(g, ["guess"] if guess else [], 73 if guess else 70)
    motion = g.scaled(g("Tanh", g.linear(x, WIDTH, 3)), 0.002 if guess else 0.02)
    if guess:
        motion = g("Add", motion, "guess")
    g("Mul", motion, mask, out="motion")
    spec = {"outline_points": 32, "guess": "planar" if guess else "none", "max_objects": 10, "lengths": [0.05, 0.1]}
    return g, OBJECTS + ([GUESS] if guess else []) + [PRESENT], [MOTION], {"spec": spec | {"engine": "none"}}


def ppn():
    g = Graph(2)
    target = g("Unsqueeze", "target", g.constant(np.array([2], np.int64)))
    x, mask = objects(g, [target], 71)
    total = g("ReduceSum", g("Mul", x, mask), g.constant(np.array([1], np.int64)), keepdims=0)
    value_ = g("Sigmoid", g.linear(total, WIDTH, 1))
    g("Reshape", value_, g.constant(np.array([-1], np.int64)), out="value")
    return g, OBJECTS + [PRESENT, TARGET], [value("value", "batch")], {"spec": {"outline_points": 32}}


def features(g, channels, stride):
    # Metres are small numbers: the weights are large for them.
    kernel, bias = g.weight(4, channels, 3, 3, scale=2.0), g.weight(4, scale=0.3)
    x = g("Conv", "image", kernel, bias, strides=[stride, stride], pads=[1, 1, 1, 1])
    return g("Relu", x)


IMAGE = {"spec": {"pixel": 0.002, "size": SIDE, "angles": 16}, "gripper": "robotiq_2f85"}


def gc():
    g = Graph(3)
    x = g("GlobalAveragePool", features(g, 2, 2))
    x = g("Reshape", x, g.constant(np.array([0, 4], np.int64)))
    x = g("Sigmoid", g.linear(x, 4, 1))
    g("Reshape", x, g.constant(np.array([-1], np.int64)), out="probability")
    return g, [value("image", "batch", 2, SIDE, SIDE)], [value("probability", "batch")], IMAGE | {"threshold": "0.5"}


def gn():
    g = Graph(4)
    x = g("Conv", features(g, 2, 2), g.weight(16, 4, 3, 3), g.weight(16), pads=[1, 1, 1, 1])
    g("Sigmoid", x, out="quality")
    image, quality = value("image", "batch", 2, SIDE, SIDE), value("quality", "batch", 16, SIDE // 2, SIDE // 2)
    return g, [image], [quality], IMAGE | {"threshold": "0.3"}


def segmentation():
    g = Graph(5)
    x = features(g, 1, 1)
    first = g.constant(np.array([1], np.int64))
    for name, channels in (("foreground", 1), ("centre", 1), ("offset", 2)):
        y = g("Conv", x, g.weight(channels, 4, 1, 1), g.weight(channels))
        if name == "offset":
            g("Mul", g("Tanh", y), g.constant(np.float32(0.03)), out=name)
        else:
            g("Squeeze", g("Sigmoid", y), first, out=name)
    outputs = [value(name, "batch", SIDE, SIDE) for name in ("foreground", "centre")]
    outputs.append(value("offset", "batch", 2, SIDE, SIDE))
    return g, [value("image", "batch", 1, SIDE, SIDE)], outputs, {"spec": {"pixel": 0.002, "size": SIDE}}


def torchvision():
    """Two instances whatever the picture: its left and its right half. The outputs of torchvision's Mask R-CNN."""
    g = Graph(6)
    left = np.zeros((2, 1, SIDE, SIDE), np.float32)
    left[0, :, :, : SIDE // 2] = 0.9
    left[1, :, :, SIDE // 2 :] = 0.8
    zero = g.scaled(g("ReduceMean", "image", keepdims=0), 0.0)
    boxes = np.array([[0, 0, SIDE // 2, SIDE], [SIDE // 2, 0, SIDE, SIDE]], np.float32)
    g("Add", g.constant(boxes), zero, out="boxes")
    g("Add", g.constant(np.array([0.95, 0.4], np.float32)), zero, out="scores")
    g("Add", g.constant(left), zero, out="masks")
    g("Identity", g.constant(np.array([1, 1], np.int64)), out="labels")
    outputs = [value("boxes", "found", 4), value("labels", "found", dtype=TensorProto.INT64)]
    outputs += [value("scores", "found"), value("masks", "found", 1, "height", "width")]
    return g, [value("image", 3, SIDE, SIDE)], outputs, {"spec": {}, "interface": "2"}


def self_test(path, inputs):
    """The expected answers, as onnxruntime computes them here."""
    stream, feed, sizes = Lcg(20), {}, {"batch": 2, "num_objects": 3}
    for tensor in inputs:
        dims = [d.dim_value or sizes[d.dim_param] for d in tensor.type.tensor_type.shape.dim]
        count = int(np.prod(dims))
        ones = tensor.name == "present"
        feed[tensor.name] = (np.ones(count, np.float32) if ones else stream.take(count)).reshape(dims)
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    names = [output.name for output in session.get_outputs()]
    answers = dict(zip(names, session.run(None, feed)))
    expected = {name: [float(v) for v in answer.ravel()[:OUTPUTS]] for name, answer in answers.items()}
    return {"seed": 20, "expected": expected, "atol": 1e-4} | sizes


def write(name, kind, made):
    g, inputs, outputs, settings = made
    # Operators of version 18 and IR 10, as every network of the project has them.
    graph = helper.make_graph(g.nodes, name, inputs, outputs, g.weights)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10, producer_name="make.py")
    metadata = {"kind": kind, "interface": "1", "version": "test", "licence": "MIT OR Apache-2.0", "metrics": "{}"}
    metadata |= settings | {"spec": json.dumps(settings["spec"])}
    helper.set_model_props(model, metadata)
    path = HERE / f"{name}.onnx"
    onnx.save(model, path)
    if metadata["interface"] == "1":
        metadata["selftest"] = json.dumps(self_test(path, inputs))
    helper.set_model_props(model, metadata)
    onnx.checker.check_model(model, full_check=True)
    onnx.save(model, path)
    print(f"{path.name}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    write("dipn", "dipn", dipn(True))
    write("dipn_none", "dipn", dipn(False))
    write("ppn", "ppn", ppn())
    write("gc", "gc", gc())
    write("gn", "gn", gn())
    write("segmentation", "segmentation", segmentation())
    write("torchvision", "segmentation", torchvision())
