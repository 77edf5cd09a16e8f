"""Writes a checkpoint as an ONNX file that the library loads: metadata and a self-test are inside.

    python -m jostle_training.export DIR/dipn.pt -o models/dipn.onnx --metrics DIR/dipn-metrics.json
"""

import argparse
import copy
import json
import sys
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import torch
from torch import nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from . import __version__, nets, selftest
from .source import commit_of_source

OPSET, IR = 18, 10
INTERFACE = 1
SEED = 20240601
# Of the self-test.
TOLERANCE = 1e-3
OBJECTS = {"outline": (32, 2), "centre": (2,), "body": (4,), "guess": (3,), "present": (), "target": ()}
SEGMENT = 224


def input_shapes(kind, batch, objects):
    """Sizes of each input, in the order of the interface."""
    shapes = {}
    for name in nets.module(kind).INPUTS:
        if name == "image":
            shapes[name] = [batch, 1, SEGMENT, SEGMENT] if kind == "segmentation" else [batch, 2, 112, 112]
        elif name == "push":
            shapes[name] = [batch, 4]
        else:
            shapes[name] = [batch, objects, *OBJECTS[name]]
    return shapes


def folded(net):
    """A copy for inference whose batch normalisations are part of the convolutions before them, and whose weights that
    are worked out from others are so for good."""
    net = copy.deepcopy(net).eval()
    for module in list(net.modules()):
        if hasattr(module, "freeze"):
            module.freeze()
        if isinstance(module, nn.Sequential):
            for k in range(len(module) - 1):
                if isinstance(module[k], nn.Conv2d) and isinstance(module[k + 1], nn.BatchNorm2d):
                    module[k] = fuse_conv_bn_eval(module[k], module[k + 1])
                    module[k + 1] = nn.Identity()
    return net


def to_onnx(net, kind):
    """The graph, without metadata."""
    example = {k: torch.from_numpy(v) for k, v in selftest.inputs(input_shapes(kind, 3, 5), 1).items()}
    batch, objects = torch.export.Dim("batch", min=1, max=4096), torch.export.Dim("num_objects", min=1, max=64)
    dynamic = {name: {0: batch, 1: objects} if name in OBJECTS else {0: batch} for name in example}
    program = torch.onnx.export(
        folded(net), tuple(example.values()), dynamo=True, opset_version=OPSET, dynamic_shapes=tuple(dynamic.values()),
        input_names=list(example), output_names=list(nets.module(kind).OUTPUTS), optimize=True, verbose=False)
    model = program.model_proto
    model.ir_version = min(model.ir_version, IR)
    # The exporter's notes (stack traces, module names) name files of this machine.
    for node in model.graph.node:
        node.doc_string = ""
        del node.metadata_props[:]
    for value in list(model.graph.value_info) + list(model.graph.input) + list(model.graph.output):
        del value.metadata_props[:]
    for tensor in model.graph.initializer:
        tensor.doc_string = ""
        del tensor.metadata_props[:]
    del model.graph.metadata_props[:]
    del model.metadata_props[:]
    del model.graph.value_info[:]
    # A network without a guess does not ask for one.
    used = {name for node in model.graph.node for name in node.input}
    for value in [v for v in model.graph.input if v.name not in used]:
        model.graph.input.remove(value)
    keep_short_indices(model)
    return model


def keep_short_indices(model):
    """Takes out casts of Gather's indices from 32 to 64 bits, which torch wants and ONNX does not."""
    types = {v.name: v.type.tensor_type.elem_type for v in onnx.shape_inference.infer_shapes(model).graph.value_info}
    casts = {node.output[0]: node for node in model.graph.node if node.op_type == "Cast"}
    for node in model.graph.node:
        cast = casts.get(node.input[1]) if node.op_type == "Gather" else None
        if cast is not None and types.get(cast.input[0]) == onnx.TensorProto.INT32:
            node.input[1] = cast.input[0]
    used = {name for node in model.graph.node for name in node.input}
    for cast in [c for c in casts.values() if c.output[0] not in used]:
        model.graph.node.remove(cast)


def session(model):
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])


def run(model, feed):
    """Outputs by name."""
    s = session(model)
    feed = {i.name: feed[i.name] for i in s.get_inputs()}
    names = [o.name for o in s.get_outputs()]
    return dict(zip(names, s.run(names, feed)))


def self_test(model, kind, objects=3, tries=48):
    """A seed, positions in each output whose values differ for it, and these values."""
    asked = {i.name for i in model.graph.input}
    # Where an item has one value, more items.
    batch = 8 if kind in ("gc", "ppn") else 2
    shapes = {k: v for k, v in input_shapes(kind, batch, objects).items() if k in asked}
    opened, best = session(model.SerializeToString()), None
    names = [o.name for o in opened.get_outputs()]
    for seed in range(SEED, SEED + tries):
        out = dict(zip(names, opened.run(None, selftest.inputs(shapes, seed, scene=True))))
        flat = {k: v.reshape(-1) for k, v in out.items()}
        at = {k: selftest.telling(v, grain=TOLERANCE) for k, v in flat.items()}
        # Of the output that varies least: how many values, and how much they differ.
        worth = min((len(at[k]), float(np.std(v[at[k]]))) for k, v in flat.items())
        if best is None or worth > best[0]:
            best = worth, seed, at, flat
    (count, spread), seed, at, flat = best
    if spread < 10 * TOLERANCE:
        print(f"the self-test tells little: {count} values that differ by {spread:.1g}", file=sys.stderr)
    expected = {k: [round(float(v[i]), 7) for i in at[k]] for k, v in flat.items()}
    return dict(inputs="scene", seed=seed, batch=batch, num_objects=objects, atol=TOLERANCE, at=at, expected=expected)


def spec(config, data):
    """What the numbers mean, per kind."""
    kind = config["kind"]
    if kind == "dipn":
        return dict(outline_points=32, guess=config.get("net", {}).get("guess", "planar"), max_objects=32,
                    lengths=data.get("lengths", [0.03, 0.12]), engine=data.get("engine", "unknown"))
    if kind == "ppn":
        return dict(outline_points=32, max_objects=32, engine=data.get("engine", "unknown"))
    if kind == "segmentation":
        return dict(pixel=0.002, size=SEGMENT)
    return dict(pixel=0.002, size=112, gripper="robotiq_2f85", angles=16)


def metadata(checkpoint, metrics, version, commit):
    config, kind = checkpoint["config"], checkpoint["config"]["kind"]
    threshold = metrics.get("threshold", 0.5 if kind in ("gc", "gn") else None)
    described = spec(config, metrics.get("data", {}))
    if threshold is not None and kind in ("gc", "gn"):
        described["threshold"] = threshold
    return {
        "kind": kind, "interface": str(INTERFACE), "version": version, "spec": json.dumps(described),
        "gripper": "robotiq_2f85" if kind in ("gc", "gn", "ppn") else "",
        "threshold": "" if threshold is None else str(threshold),
        "dataset_sha256": checkpoint.get("dataset_sha256") or "", "train_commit": commit,
        "licence": "MIT OR Apache-2.0", "metrics": json.dumps(metrics.get("metrics", metrics)),
    }


def write(checkpoint, path, metrics=None, version="1", commit=None):
    """Exports, adds metadata and self-test, compares with torch; returns the largest difference."""
    config, kind = checkpoint["config"], checkpoint["config"]["kind"]
    net = nets.build(kind, config.get("profile", "fast"), **config.get("net", {}))
    net.load_state_dict(checkpoint["net"])
    net.eval()
    model = to_onnx(net, kind)
    properties = metadata(checkpoint, metrics or {}, version, commit or checkpoint.get("commit") or commit_of_source())
    properties["selftest"] = json.dumps(self_test(model, kind))
    onnx.helper.set_model_props(model, properties)
    model.producer_name, model.producer_version, model.doc_string = "jostle_training", __version__, ""
    onnx.checker.check_model(model, full_check=True)
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_bytes(model.SerializeToString())
    return parity(net, kind, str(path))


def parity(net, kind, path):
    """The largest difference between torch and ONNX Runtime, for several sizes."""
    worst = 0.0
    for batch, objects in ((1, 1), (2, 3), (5, 10)):
        feed = selftest.inputs(input_shapes(kind, batch, objects), 11 + batch, scene=True)
        with torch.no_grad():
            wanted = net(*(torch.from_numpy(v) for v in feed.values()))
        wanted = wanted if isinstance(wanted, tuple) else (wanted,)
        got = run(path, feed)
        for name, value in zip(nets.module(kind).OUTPUTS, wanted):
            if got[name].shape != tuple(value.shape):
                raise ValueError(f"{name} has shape {got[name].shape} in ONNX Runtime and {tuple(value.shape)} in torch")
            worst = max(worst, float(np.abs(got[name] - value.numpy()).max()))
    return worst


def again(path, metrics, output):
    """An exported file with a new self-test, and with new figures where there are some; the network stays as it is."""
    model = onnx.load(path)
    properties = {p.key: p.value for p in model.metadata_props}
    properties["selftest"] = json.dumps(self_test(model, properties["kind"]))
    if metrics:
        properties["metrics"] = json.dumps(metrics.get("metrics", metrics))
    onnx.helper.set_model_props(model, properties)
    output.write_bytes(model.SerializeToString())


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoint", type=Path, help="or an exported file, which gets a new self-test (and figures)")
    p.add_argument("-o", "--output", type=Path, required=True)
    p.add_argument("--metrics", type=Path, help="JSON of jostle_training.eval, for metadata and threshold")
    p.add_argument("--version", default="1")
    args = p.parse_args()
    metrics = json.loads(args.metrics.read_text()) if args.metrics else {}
    if args.checkpoint.suffix == ".onnx":
        return again(args.checkpoint, metrics, args.output)
    checkpoint = torch.load(args.checkpoint, weights_only=True)
    difference = write(checkpoint, args.output, metrics, args.version)
    print(json.dumps(dict(file=str(args.output), bytes=args.output.stat().st_size, largest_difference=difference)))
    if difference > 1e-3:
        sys.exit("torch and ONNX Runtime differ")


if __name__ == "__main__":
    main()
