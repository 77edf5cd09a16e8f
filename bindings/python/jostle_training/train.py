"""Trains one network for a number of minutes. Stops and goes on as often as one likes.

    python -m jostle_training.train configs/dipn.toml --data DATA/push-prism --checkpoint DIR/dipn.pt --minutes 30
"""

import argparse
import copy
import hashlib
import json
import os
import sys
import time
import tomllib
from pathlib import Path

import torch

from .data import manifest_hash
from .source import commit_of_source
from .tasks import task


def parameters():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("config", type=Path)
    p.add_argument("--data", required=True, help="folder of shards")
    p.add_argument("--checkpoint", required=True, type=Path, help="read if it is there, and written")
    p.add_argument("--minutes", type=float, default=10, help="of wall time; the rate of learning falls over them")
    p.add_argument("--steps", type=int, help="stop after so many steps instead")
    p.add_argument("--from", dest="warm", type=Path, help="start from the weights of another checkpoint")
    p.add_argument("--limit", type=int, help="use about so many samples")
    p.add_argument("--rate", type=float, help="instead of the configuration's rate of learning")
    p.add_argument("--save-every", type=float, default=2, help="minutes")
    p.add_argument("--score-every", type=float, default=4, help="minutes")
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--device", default="cpu")
    p.add_argument("--log", type=Path)
    return p.parse_args()


def save(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    torch.save(content, part)
    os.replace(part, path)


def matching(state, net):
    """The entries of `state` that have a place in `net`. A layer with more inputs here weighs the others with zero."""
    mine, out = net.state_dict(), {}
    for name, tensor in state.items():
        if name not in mine:
            continue
        want = mine[name].shape
        if want == tensor.shape:
            out[name] = tensor
        elif tensor.dim() == 2 and len(want) == 2 and want[0] == tensor.shape[0] and want[1] > tensor.shape[1]:
            out[name] = torch.cat([tensor, tensor.new_zeros(want[0], want[1] - tensor.shape[1])], 1)
    return out


class Average:
    """Exponential average of the weights; what is judged and exported."""

    def __init__(self, net, keep=0.998):
        self.net, self.keep, self.count = copy.deepcopy(net).eval(), keep, 0

    @torch.no_grad()
    def take(self, net):
        self.count += 1
        keep = min(self.keep, self.count / (self.count + 10))
        for mine, theirs in zip(self.net.state_dict().values(), net.state_dict().values()):
            if mine.dtype.is_floating_point:
                mine.lerp_(theirs, 1 - keep)
            else:
                mine.copy_(theirs)


def schedule(progress):
    """Warm up, stay, then fall to a fiftieth over the second half."""
    if progress < 0.02:
        return 0.1 + 0.9 * progress / 0.02
    return 1.0 if progress < 0.5 else max(0.02, 1 - (progress - 0.5) / 0.5)


def main():
    args = parameters()
    torch.set_num_threads(args.threads)
    config = tomllib.loads(args.config.read_text())
    torch.manual_seed(config.get("seed", 1))
    job = task(config, args.data, args.limit)
    device = torch.device(args.device)
    done = dict(step=0, samples=0, cpu_seconds=0.0, wall_seconds=0.0, best=None, sources=[])
    net = job.net
    if args.checkpoint.exists():
        found = torch.load(args.checkpoint, weights_only=True)
        net.load_state_dict(found["raw"])
        done.update(found["done"])
    elif args.warm:
        found = matching(torch.load(args.warm, weights_only=True)["net"], net)
        net.load_state_dict(found, strict=False)
        print(f"{len(found)} of {len(net.state_dict())} tensors come from {args.warm}", file=sys.stderr)
        job.fit() if config.get("fit_again") else None
        found = None
    else:
        job.fit()
        found = None
    net.to(device).train()
    average = Average(net)
    rate = args.rate or config.get("rate", 1e-3)
    optimiser = torch.optim.AdamW(net.parameters(), lr=rate, weight_decay=config.get("decay", 1e-4))
    if found:
        average.net.load_state_dict(found["net"])
        average.count = done["step"]
        optimiser.load_state_dict(found["optimiser"])
        job.generator.manual_seed(done["step"] + 7)
    source = Path(args.data).name
    if source not in done["sources"]:
        done["sources"].append(source)

    # Of the start: files that change later are not what trains.
    commit = commit_of_source()
    log = open(args.log, "a") if args.log else sys.stderr
    start, cpu_start = time.monotonic(), time.process_time()
    before = (done["cpu_seconds"], done["wall_seconds"], done["step"])
    last_save = last_score = last_look = start
    running, batches = None, job.batches()

    def checkpoint():
        done["cpu_seconds"] = before[0] + time.process_time() - cpu_start
        done["wall_seconds"] = before[1] + time.monotonic() - start
        save(args.checkpoint, dict(
            net=average.net.state_dict(), raw=net.state_dict(), optimiser=optimiser.state_dict(), config=config,
            done=done, dataset_sha256=manifest_hash(args.data), commit=commit,
            config_sha256=hashlib.sha256(args.config.read_bytes()).hexdigest()))

    def judge():
        with torch.no_grad():
            average.net.to("cpu")
            score, figures = job.score(average.net)
            average.net.to(device)
        done["best"] = score
        entry = dict(step=done["step"], samples=done["samples"], train_loss=running, **figures,
                     minutes=round((time.monotonic() - start) / 60, 1))
        print(json.dumps(entry), file=log, flush=True)

    while True:
        now = time.monotonic()
        part = (done["step"] - before[2]) / args.steps if args.steps else (now - start) / 60 / args.minutes
        if part >= 1:
            break
        for group in optimiser.param_groups:
            group["lr"] = rate * schedule(part)
        batch = {k: v.to(device) for k, v in next(batches).items()}
        loss = job.loss(batch)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), config.get("clip", 1.0))
        optimiser.step()
        average.take(net)
        done["step"] += 1
        done["samples"] += len(next(iter(batch.values())))
        value = float(loss.detach())
        running = value if running is None else running + (value - running) * 0.01
        if now - last_look > 60:
            last_look = now
            if job.refresh():
                print(json.dumps(dict(samples_known=len(job.data))), file=log, flush=True)
                batches = job.batches()
        if now - last_score > 60 * args.score_every:
            judge()
            last_score = time.monotonic()
        if now - last_save > 60 * args.save_every:
            checkpoint()
            last_save = time.monotonic()
    judge()
    checkpoint()
    log.flush()


if __name__ == "__main__":
    main()
