"""The networks, by kind. Each module has `build(profile, **options)`, `INPUTS` and `OUTPUTS`."""

from importlib import import_module

KINDS = ("dipn", "ppn", "gc", "gn", "segmentation")


def module(kind):
    if kind not in KINDS:
        raise ValueError(f"no network is called {kind!r}; there are {', '.join(KINDS)}")
    return import_module(f".{kind}", __name__)


def build(kind, profile="fast", **options):
    return module(kind).build(profile, **options)
