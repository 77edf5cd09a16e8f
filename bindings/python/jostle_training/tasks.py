"""What each kind of network learns: its data, its loss, and the figure by which it is judged while it trains."""

import math

import torch
from torch.nn import functional

from . import nets
from .data import ANGLES, CELLS, CROP, Grasps, Pushes, Scenes, TRAIN, VALIDATION, Values, mirrored, symmetric
from .nets import segmentation

MILLIMETRE = 1e-3


def outline_distance(outline, motion, truth):
    """Mean distance, in metres, between the 32 points of each outline moved one way and the other: [B,N]."""
    x, y = outline[..., 0], outline[..., 1]
    a, b = motion[..., 2:], truth[..., 2:]
    dc, ds = a.cos() - b.cos(), a.sin() - b.sin()
    dx = dc * x - ds * y + motion[..., :1] - truth[..., :1]
    dy = ds * x + dc * y + motion[..., 1:2] - truth[..., 1:2]
    return (dx.square() + dy.square() + (0.3 * MILLIMETRE) ** 2).sqrt().mean(-1)


class Task:
    """`batches` yields training batches for ever, `loss` is what to minimise, `score` is validated (less is better)."""

    autocast = False

    def __init__(self, config, folder, limit=None, generator=None):
        self.config, self.generator = config, generator or torch.Generator().manual_seed(config.get("seed", 1))
        self.net = nets.build(config["kind"], config.get("profile", "fast"), **config.get("net", {}))
        self.data = self.table(folder, limit)
        self.batch_size = config.get("batch", 64)

    def choose(self, rows, count):
        return rows[torch.randint(len(rows), (count,), generator=self.generator)]

    def refresh(self):
        return self.data.refresh()


class DipnTask(Task):
    table = Pushes

    def fit(self):
        rows = self.data.rows[TRAIN][:20_000]
        n = self.data.table["n"][rows]
        body = self.data.table["body"][rows]
        present = torch.arange(body.shape[1]) < n[:, None]
        push = self.data.table["push"][rows][:, None].expand(-1, body.shape[1], -1)
        self.net.fit(body[present], push[present])

    def batches(self):
        whole = self.config.get("whole", 0.15)
        while True:
            groups = self.data.groups(TRAIN)
            weights = torch.tensor([len(r) for r in groups.values()], dtype=torch.float)
            keys = list(groups)
            for _ in range(200):
                key = keys[int(torch.multinomial(weights, 1, generator=self.generator))]
                rows = self.choose(groups[key], self.batch_size)
                everything = torch.rand((), generator=self.generator) < whole
                batch = self.data.batch(rows, None if everything else key)
                sign = (torch.rand(len(rows), generator=self.generator) < 0.5).float() * 2 - 1
                yield mirrored(batch, sign)

    def loss(self, batch):
        motion = self.net(*(batch[k] for k in nets.module("dipn").INPUTS))
        error = outline_distance(batch["outline"], motion, batch["motion"]) / MILLIMETRE
        return (error * batch["present"]).sum() / batch["present"].sum()

    def score(self, net, rows_limit=2000):
        """Mean outline distance in mm over the bodies that moved, of the network, the guess, and no motion."""
        rows = self.data.rows[VALIDATION][:rows_limit]
        sums = torch.zeros(4)
        for part in rows.split(200):
            batch = self.data.batch(part)
            motion = net(*(batch[k] for k in nets.module("dipn").INPUTS))
            moved = (batch["motion"].abs() > 1e-3).any(-1).float() * batch["present"]
            for k, m in enumerate((motion, batch["guess"], torch.zeros_like(motion))):
                sums[k] += (outline_distance(batch["outline"], m, batch["motion"]) * moved).sum() / MILLIMETRE
            sums[3] += moved.sum()
        net_mm, guess_mm, still_mm = (sums[:3] / sums[3].clamp(min=1)).tolist()
        return net_mm, dict(moved_mm=net_mm, guess_mm=guess_mm, static_mm=still_mm)


class PpnTask(Task):
    """Soft targets: the value of each push, and which of a state's pushes is best."""

    table = Values

    def fit(self):
        rows = self.data.rows[TRAIN][:500]
        batch = self.data.batch(rows)
        present = batch["present"] > 0
        push = batch["push"][:, None].expand(-1, present.shape[1], -1)
        self.net.fit(batch["body"][present], push[present])

    def batches(self):
        states = self.config.get("states", 8)
        while True:
            order = self.data.rows[TRAIN]
            order = order[torch.randperm(len(order), generator=self.generator)]
            order = order[self.data.table["n"][order].argsort()]
            parts = [p for p in order.split(states) if len(p)]
            for k in torch.randperm(len(parts), generator=self.generator).tolist():
                batch = self.data.batch(parts[k])
                sign = (torch.rand(len(batch["q"]), generator=self.generator) < 0.5).float() * 2 - 1
                yield mirrored(batch, sign)

    def loss(self, batch):
        logit, _ = self.net.logit(*(batch[k] for k in nets.module("ppn").INPUTS))
        q = batch["q"].clamp(0, 1)
        # A push that was looked at once has an uncertain value.
        weight = (batch["visits"] / (batch["visits"] + 5)).clamp(min=0.1)
        value = (functional.binary_cross_entropy_with_logits(logit, q, reduction="none") * weight).mean()
        # Which is best: cross-entropy of the softmax over each state's pushes with that of their labels.
        count = int(batch["state"].max()) + 1
        sharp = self.config.get("sharp", 15.0)
        rank = 0.0
        for s in range(count):
            mine = batch["state"] == s
            wanted = torch.softmax(q[mine] * sharp + weight[mine].log(), 0)
            rank = rank - (wanted * torch.log_softmax(torch.sigmoid(logit[mine]) * sharp, 0)).sum()
        return value + self.config.get("rank", 0.1) * rank / count

    def score(self, net, rows_limit=400):
        figures = ranking(net, self.data, self.data.rows[VALIDATION][:rows_limit])
        return 1 - figures["top1_in_best3"], figures


def ranking(net, data, states):
    """How the network's order of the pushes agrees with the search's."""
    hits, first, correlations, regrets = 0, 0, [], []
    for part in states.split(16):
        batch = data.batch(part)
        value = net(*(batch[k] for k in nets.module("ppn").INPUTS))
        for s in range(len(part)):
            mine = batch["state"] == s
            q, v = batch["q"][mine], value[mine]
            best = int(v.argmax())
            hits += int((q > q[best]).sum()) < 3
            first += int(q[best] >= q.max())
            regrets.append(float(q.max() - q[best]))
            if q.max() > q.min():
                correlations.append(spearman(q, v))
    n = max(1, len(states))
    return dict(states=len(states), top1_in_best3=hits / n, top1_is_best=first / n,
                rank_correlation=sum(correlations) / max(1, len(correlations)), regret=sum(regrets) / n)


def ranks(values):
    """Ranks with ties averaged."""
    _, inverse, counts = values.unique(return_inverse=True, return_counts=True)
    ends = counts.cumsum(0).float()
    return (ends - (counts.float() - 1) / 2)[inverse]


def spearman(a, b):
    a, b = ranks(a) - (len(a) + 1) / 2, ranks(b) - (len(b) + 1) / 2
    return float((a * b).sum() / (a.norm() * b.norm()).clamp(min=1e-9))


class ImageTask(Task):
    table = Grasps
    autocast = True

    def fit(self):
        pass

    def maps(self, rows):
        return self.data.maps(rows)

    def batches(self):
        while True:
            rows = self.choose(self.data.rows[TRAIN], self.batch_size)
            image, quality = self.data.images(rows), self.maps(rows)
            parts = [symmetric(i, q, int(torch.randint(8, (), generator=self.generator)))
                     for i, q in zip(image.chunk(8), quality.chunk(8))]
            yield dict(image=torch.cat([p[0] for p in parts]), quality=torch.cat([p[1] for p in parts]),
                       score=self.data.best[rows])


class GcTask(ImageTask):
    """The answer, that of the geometric test's own search, and which places have a grasp on the grid."""

    def __init__(self, config, *rest, **options):
        super().__init__(config, *rest, **options)
        self.least = config.get("least_score", 0.3)
        self.doubt = torch.full((len(self.data),), 0.5)  # how far off the answer was when last asked
        if not hasattr(self.net, "place_of"):
            return
        # The place of each of the grasp map's cells, for each of the eight ways to lay an image down.
        cells = torch.arange(ANGLES * CELLS**2)
        place = self.net.place_of(cells // CELLS**2, cells // CELLS % CELLS, cells % CELLS)
        self.place = torch.empty(8, len(cells), dtype=torch.long)
        for which in range(8):
            _, old = symmetric(cells[:, None], cells.reshape(ANGLES, CELLS, CELLS), which)
            self.place[which, old.flatten()] = place
        count = self.net.ROWS * ANGLES * self.net.COLS
        self.known = torch.zeros(8, count + 1)
        self.known.scatter_(1, self.place.remainder(count + 1), 1.0)
        self.known = self.known[:, :count]

    def batches(self):
        while True:
            rows, weight = self.doubtful(self.data.rows[TRAIN])
            which = torch.randint(8, (len(rows),), generator=self.generator).sort().values
            image = self.data.images(rows)
            image = torch.cat([symmetric(image[which == w], None, w)[0] for w in which.unique().tolist()])
            batch = dict(image=image, score=self.data.table["score"][rows], weight=weight, row=rows)
            if hasattr(self, "place"):
                batch["places"], batch["known"] = self.places(rows, which), self.known[which]
            yield batch

    def refresh(self):
        found = super().refresh()
        self.doubt = torch.cat([self.doubt, torch.full((len(self.data) - len(self.doubt),), 0.5)])
        return found

    def doubtful(self, rows):
        """Rows, the oftener the farther off their answers were, and weights that make up for it."""
        chance = self.doubt[rows] + self.config.get("least_doubt", 0.1)
        chosen = torch.multinomial(chance, self.batch_size, replacement=True, generator=self.generator)
        return rows[chosen], chance.mean() / chance[chosen]

    def places(self, rows, which):
        """1 at each place that has a cell with a grasp: [B,places]."""
        t, count = self.data.table, self.data.table["count"][rows]
        row = torch.repeat_interleave(torch.arange(len(rows)), count)
        start = torch.cat([count.new_zeros(1), count.cumsum(0)[:-1]])
        at = torch.arange(len(row)) + (self.data.first[rows] - start)[row]
        place = self.place[which[row], t["cell"][at].long()]
        good = (t["cell_score"][at] >= self.least) & (place >= 0)
        out = torch.zeros(len(rows), self.known.shape[1])
        out[row[good], place[good]] = 1
        return out

    def loss(self, batch):
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.get("half", False)):
            logit, places = self.net.logits(batch["image"])
        truth = (batch["score"] >= self.least).float()
        loss = functional.binary_cross_entropy_with_logits(logit.float(), truth, batch["weight"])
        off = (torch.sigmoid(logit.detach().float()) - truth).abs()
        self.doubt[batch["row"]] = 0.5 * (self.doubt[batch["row"]] + off)
        if places is not None:
            wanted = batch["places"]
            # Where few places have a grasp each of them counts for more. Not made up for: doubtful rows teach most.
            # A grid grasp that the test's own search does not know is left out.
            unknown = (truth[:, None] < wanted).float()
            weight = (batch["known"] - unknown) * (1 + wanted * (32 / wanted.sum(1, keepdim=True).clamp(min=1)).clamp(0.25, 8))
            aux = functional.binary_cross_entropy_with_logits(places.float(), wanted, weight)
            loss = loss + self.config.get("map", 5.0) * aux
        return loss

    def score(self, net, rows_limit=2000):
        rows = self.data.rows[VALIDATION][:rows_limit]
        probability = torch.cat([net(self.data.images(part)) for part in rows.split(100)])
        truth = self.data.table["score"][rows] >= self.least
        accuracy, threshold = best_threshold(probability, truth)
        return 1 - accuracy, dict(accuracy=accuracy, threshold=threshold, positive=float(truth.float().mean()))


def best_threshold(probability, truth):
    accuracies = [(float(((probability >= t) == truth).float().mean()), round(t, 2))
                  for t in (torch.arange(20, 81) / 100).tolist()]
    return max(accuracies, key=lambda a: (a[0], -abs(a[1] - 0.5)))


class GnTask(ImageTask):
    """Single places and angles, not whole maps: grasps, and what looks most like one among places that have the target
    between the fingers. What the windows show there is kept, and learned from several times before other rows take
    its place."""

    def batches(self):
        if not hasattr(self.net, "window"):
            while True:
                rows = self.choose(self.data.rows[TRAIN], self.batch_size)
                yield dict(image=self.data.images(rows), quality=self.data.maps(rows))
        chunk, chunks = self.config.get("chunk", 1000), self.config.get("chunks", 16)
        each = self.config.get("keep", 64) + self.config.get("grasps", 32)
        size, taps = chunk * each, sum(self.net.window.sizes)
        shown = torch.empty(chunks * size, taps, dtype=torch.uint8)
        truth, weight = torch.empty(chunks * size), torch.empty(chunks * size)
        steps = int(self.config.get("reuse", 6) * size / self.batch_size)
        order, k = torch.empty(0, dtype=torch.long), 0
        while True:
            while len(order) < chunk:
                train = self.data.rows[TRAIN]
                order = torch.cat([order, train[torch.randperm(len(train), generator=self.generator)]])
            at = slice(k % chunks * size, (k % chunks + 1) * size)
            shown[at], truth[at], weight[at] = (torch.cat(p) for p in zip(*map(self.look, order[:chunk].split(20))))
            order, k = order[chunk:], k + 1
            known = min(k, chunks) * size
            for _ in range(steps):
                rows = torch.randint(known, (self.batch_size,), generator=self.generator)
                yield dict(shown=self.mirrored(shown[rows]), quality=truth[rows], weight=weight[rows])

    def mirrored(self, shown):
        """A quarter each as it is and in three mirrors, along the closing direction and along the pads: they score the
        same."""
        parts = []
        for k, part in enumerate(shown.split((len(shown) + 3) // 4)):
            flips = [axis for axis in (1, 2) if k & axis]
            windows = zip(part.split(self.net.window.sizes, 1), self.net.window.grids)
            parts.append(torch.cat([w.unflatten(1, g).flip(flips).flatten(1) for w, g in windows], 1))
        return torch.cat(parts)

    @torch.no_grad()
    def look(self, rows):
        """What the windows show at the chosen places of some rows, in 255ths, the scores there and the weights."""
        net, half = self.net, self.net.HALF
        image, wanted = self.data.images(rows), self.data.maps(rows).flatten(1)
        angle, row, col = self.candidates(image[:, 1].flatten(1))
        cell, some = self.grasps(rows)
        angle = torch.cat([angle, cell // CELLS**2], 1)
        row, col = torch.cat([row, cell // CELLS % CELLS], 1), torch.cat([col, cell % CELLS], 1)
        row, col = (x.clamp(CELLS // 2 - half, CELLS // 2 + half - 1) for x in (row, col))
        truth = wanted.gather(1, (angle * CELLS + row) * CELLS + col)
        which = torch.arange(len(image))[:, None].expand_as(angle)
        places = [which, angle, row, col]
        planes = net.window.planes(image)
        # To choose by, roughly is enough.
        with torch.autocast("cpu", torch.bfloat16):
            rough = net.judge(*net.window.places(planes.bfloat16(), *(x.reshape(-1) for x in places)))
        doubt = (torch.sigmoid(rough.float()).reshape(truth.shape) - truth).abs() + self.config.get("least_doubt", 0.03)
        n, keep = truth.shape[1] - cell.shape[1], self.config.get("keep", 64)
        chosen = torch.multinomial(doubt[:, :n], keep, generator=self.generator)
        rest = torch.arange(n, truth.shape[1]).expand(len(image), -1)
        # What is drawn oftener weighs less, if not in full: what looks like a grasp and is none matters most.
        weight = (doubt[:, :n].mean(1, keepdim=True) / doubt.gather(1, chosen)) ** self.config.get("even", 0.5)
        sure = torch.full(rest.shape, self.config.get("grasp_weight", 0.5)) * some[:, None]
        weight, chosen = torch.cat([weight, sure], 1), torch.cat([chosen, rest], 1)
        shown = net.window.places(planes, *(x.gather(1, chosen).reshape(-1) for x in places))
        shown = (torch.cat(shown, 1) * 255 + 0.5).clamp(0, 255).to(torch.uint8)
        return shown, truth.gather(1, chosen).flatten(), weight.flatten()

    def grasps(self, rows):
        """Grasps drawn from each row's: index of the cell; 0 and not `some` where it has none."""
        count, most = self.data.table["count"][rows], self.config.get("grasps", 32)
        draw = (torch.rand(len(rows), most, generator=self.generator) * count[:, None]).long()
        place = (self.data.first[rows][:, None] + draw).clamp(max=len(self.data.table["cell"]) - 1)
        return self.data.table["cell"][place].long(), count > 0

    def candidates(self, target):
        """Places that have a pixel of the target [B,112*112] between the fingers: angle, row, column [B,n] each."""
        n = self.config.get("candidates", 384)
        random = lambda *a: torch.rand(*a, generator=self.generator)
        pixel = torch.multinomial(target + 1e-9, n, replacement=True, generator=self.generator)
        angle = torch.randint(ANGLES, pixel.shape, generator=self.generator)
        a = angle * (math.pi / ANGLES)
        u, v = (random(pixel.shape) - 0.5) * 76, (random(pixel.shape) - 0.5) * 22
        at = lambda p, w: ((2 * p + 1 + w) / 4).floor().long()
        return angle, at(pixel // CROP, u * a.sin() + v * a.cos()), at(pixel % CROP, u * a.cos() - v * a.sin())

    def loss(self, batch):
        if "shown" not in batch:
            logits = self.net.logits(batch["image"])
            return functional.binary_cross_entropy_with_logits(logits, batch["quality"], 1 + 3 * (batch["quality"] > 0))
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.get("half", False)):
            shown = batch["shown"].to(torch.bfloat16 if self.config.get("half", False) else torch.float32) / 255
            logit = self.net.judge(*shown.split(self.net.window.sizes, 1)).squeeze(1)
        weight = batch["weight"]
        loss = functional.binary_cross_entropy_with_logits(logit.float(), batch["quality"], weight, reduction="sum")
        return loss / weight.sum()

    def score(self, net, rows_limit=300):
        figures = arg_max(net, self.data, self.data.rows[VALIDATION][:rows_limit], 0.3)
        return 1 - figures["valid"], figures


def arg_max(net, data, rows, least=0.0):
    """Where some cell holds a grasp: is the best predicted cell one of them, and how good is it."""
    valid, states, got, best = 0, 0, 0.0, 0.0
    for part in rows.split(10):
        quality, wanted = net(data.images(part)).flatten(1), data.maps(part).flatten(1)
        some = wanted.amax(1) > least
        chosen = wanted.gather(1, quality.argmax(1, keepdim=True)).squeeze(1)
        valid += int((chosen[some] > least).sum())
        states += int(some.sum())
        got += float(chosen[some].sum())
        best += float(wanted.amax(1)[some].sum())
    return dict(states=states, valid=valid / max(1, states), score_chosen=got / max(1, states),
                score_best=best / max(1, states))


class SegmentationTask(Task):
    table = Scenes

    def fit(self):
        pass

    def batches(self):
        while True:
            rows = self.choose(self.data.rows[TRAIN], self.batch_size)
            which, phase = (int(torch.randint(n, (), generator=self.generator)) for n in (8, 4))
            self.phase = divmod(phase, 2)
            batch = self.data.batch(rows, which, self.phase)
            # Depth cameras are not exact: each image has noise of its own strength.
            noise = torch.rand(len(rows), 1, 1, 1, generator=self.generator) * self.config.get("noise", 0.001)
            batch["image"] = batch["image"] + torch.randn(batch["image"].shape, generator=self.generator) * noise
            yield batch

    def loss(self, batch):
        with torch.autocast("cpu", torch.bfloat16):
            foreground, heat, offset = self.net.maps(batch["image"], self.phase)
        there = (batch["label"] > 0).float()
        entropy = functional.binary_cross_entropy_with_logits
        warm = self.heat(batch)
        loss = entropy(foreground.float(), there) + 0.5 * entropy(heat.float(), warm, 0.1 + there + 4 * warm)
        away = functional.smooth_l1_loss(offset.float() * 200, batch["offset"] * 200, reduction="none")
        return loss + (away * there[:, None]).sum() / there.sum().clamp(min=1)

    @staticmethod
    def heat(batch, width=0.006):
        """1 at a body's centre, falling over 6 mm; only on the body itself."""
        return torch.exp(-batch["offset"].square().sum(1) / (2 * width**2)) * (batch["label"] > 0)

    def score(self, net, rows_limit=60):
        figures = instances(net, self.data, self.data.rows[VALIDATION][:rows_limit])
        return 1 - figures["matched_075"], figures


def instances(net, data, rows, least_pixels=20):
    """Bodies against instances, each body with the instance that overlaps it most."""
    overlaps, found, right, joined = [], 0, 0, 0
    for part in rows.split(10):
        batch = data.batch(part)
        for k, (truth, *maps) in enumerate(zip(batch["label"], *net(batch["image"]))):
            labels = segmentation.group(*maps)
            a, b = int(truth.max()) + 1, int(labels.max()) + 1
            both = torch.bincount((truth * b + labels).flatten(), minlength=a * b).reshape(a, b)[1:]
            mine, theirs = both.sum(1, keepdim=True), torch.bincount(labels.flatten(), minlength=b)[1:]
            there = mine[:, 0] >= least_pixels
            if b == 1:
                overlaps += [0.0] * int(there.sum())
                continue
            iou = both[:, 1:] / (mine + theirs - both[:, 1:]).clamp(min=1)
            overlaps += iou.amax(1)[there].tolist()
            found += int((theirs > 0).sum())
            right += int((iou[there].amax(0) >= 0.75).sum())
            # An instance that is most of two bodies.
            joined += int(((both[:, 1:] / mine.clamp(min=1) > 0.5)[there].sum(0) > 1).sum())
    overlaps = torch.tensor(overlaps)
    return dict(images=len(rows), bodies=len(overlaps), instances=found, mean_iou=float(overlaps.mean()),
                matched_075=float((overlaps >= 0.75).float().mean()),
                matched_050=float((overlaps >= 0.5).float().mean()), precision_075=right / max(1, found),
                instances_of_several_bodies=joined)


TASKS = dict(dipn=DipnTask, ppn=PpnTask, gc=GcTask, gn=GnTask, segmentation=SegmentationTask)


def task(config, folder, limit=None):
    kind = config["kind"]
    if kind not in TASKS:
        raise ValueError(f"no network is called {kind!r}; there are {', '.join(TASKS)}")
    return TASKS[kind](config, folder, limit)
