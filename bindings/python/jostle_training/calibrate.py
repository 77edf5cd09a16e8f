"""Makes GC's probabilities come true: stretches and shifts its answers (Platt) to fit the validation split best.

    python -m jostle_training.calibrate DIR/gc.pt --data DATA/grasp

The checkpoint's averaged weights, which are judged and exported, take it up; training that goes on starts from the others.
"""

import argparse
import json
from pathlib import Path

import torch
from torch.nn import functional

from .data import VALIDATION
from .tasks import TASKS
from .train import save
from . import nets


def platt(logit, truth, steps=50):
    """Stretch and shift that make the probabilities of `logit` fit best."""
    line = torch.tensor([1.0, 0.0], dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([line], max_iter=steps, line_search_fn="strong_wolfe")

    def closure():
        optimiser.zero_grad()
        loss = functional.binary_cross_entropy_with_logits(logit.double() * line[0] + line[1], truth.double())
        loss.backward()
        return loss

    optimiser.step(closure)
    return line.tolist()


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoint", type=Path)
    p.add_argument("--data", required=True)
    args = p.parse_args()
    torch.set_num_threads(1)
    found = torch.load(args.checkpoint, weights_only=True)
    config = found["config"]
    net = nets.build(config["kind"], config.get("profile", "fast"), **config.get("net", {}))
    net.load_state_dict(found["net"])
    net.eval()
    data = TASKS["gc"].table(args.data)
    rows = data.rows[VALIDATION]
    with torch.no_grad():
        logit = torch.cat([net.logits(data.images(part))[0] for part in rows.split(50)])
    stretch, shift = platt(logit, data.table["score"][rows] >= config.get("least_score", 0.3))
    with torch.no_grad():
        last = net.score[-1]
        last.weight.mul_(stretch)
        last.bias.mul_(stretch).add_(shift)
    found["net"] = net.state_dict()
    save(args.checkpoint, found)
    print(json.dumps(dict(stretch=round(stretch, 4), shift=round(shift, 4), states=len(rows))))


if __name__ == "__main__":
    main()
