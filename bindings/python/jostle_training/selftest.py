"""The inputs of a model's self-test: numbers that any language makes alike, and the values of its answer to look at."""

import numpy as np

MASK = (1 << 64) - 1
# Of inputs as they occur ("scene"): a number times the first plus the second. Metres, kilograms, radians.
RANGES = {"outline": (0.08, -0.04), "centre": (0.3, -0.15), "body": (0.5, 0.0), "push": (0.1, 0.02), "guess": (0.05, -0.025)}
# Images of a scene: fields a side, the part of them on which a block stands, and its height in metres.
FIELDS, STANDING, HEIGHT = 5, 0.4, 0.045


def stream(seed):
    """Numbers in [0, 1) of a linear congruential generator."""
    s = seed & MASK
    while True:
        s = (s * 6364136223846793005 + 1442695040888963407) & MASK
        yield (s >> 40) / 2**24


def inputs(shapes, seed, scene=False):
    """shapes: name to a list of sizes, in the order of the interface. `present` is all ones and takes no numbers. Of a
    scene numbers are as they occur; `target` is the first body, and takes no numbers either."""
    numbers, out = stream(seed), {}
    for name, shape in shapes.items():
        draw = lambda size: np.fromiter((next(numbers) for _ in range(size)), float, size)
        if name == "present":
            value = np.ones(shape)
        elif name == "image" and scene:
            value = np.stack([blocks(draw(FIELDS**2), shape[1], shape[2]) for _ in range(shape[0])])
        elif name == "target" and scene:
            value = np.zeros(shape)
            value[:, 0] = 1
        else:
            scale, start = RANGES[name] if scene else (1, 0)
            value = draw(int(np.prod(shape))) * scale + start
        out[name] = value.astype(np.float32).reshape(shape)
    return out


def blocks(numbers, channels, side):
    """A picture [channels, side, side] of fields with a block where the number is small, and one in the middle, which is
    the target (second channel)."""
    standing = numbers.reshape(FIELDS, FIELDS) < STANDING
    middle = np.zeros_like(standing)
    middle[FIELDS // 2, FIELDS // 2] = True
    grow = lambda fields: np.kron(fields, np.ones((-(-side // FIELDS),) * 2))[:side, :side]
    return np.stack([grow(standing | middle) * HEIGHT, grow(middle)][:channels])


def telling(values, count=8, grain=1e-3):
    """Positions of at most so many values that differ from each other, from the least to the greatest."""
    _, first = np.unique(np.round(values / grain), return_index=True)
    if len(first) > count:
        first = first[np.linspace(0, len(first) - 1, count).round().astype(int)]
    return [int(i) for i in first]
