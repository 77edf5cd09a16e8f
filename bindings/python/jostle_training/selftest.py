"""The inputs of a model's self-test: numbers that any language makes alike."""

import numpy as np

MASK = (1 << 64) - 1


def stream(seed):
    """Numbers in [0, 1) of a linear congruential generator."""
    s = seed & MASK
    while True:
        s = (s * 6364136223846793005 + 1442695040888963407) & MASK
        yield (s >> 40) / 2**24


def inputs(shapes, seed):
    """shapes: name to a list of sizes, in the order of the interface. `present` is all ones and takes no numbers."""
    numbers, out = stream(seed), {}
    for name, shape in shapes.items():
        size = int(np.prod(shape))
        flat = np.ones(size) if name == "present" else np.fromiter((next(numbers) for _ in range(size)), float, size)
        out[name] = flat.astype(np.float32).reshape(shape)
    return out
