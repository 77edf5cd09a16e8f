"""A line chart as SVG: what a report needs, and nothing that has to be installed."""

import math
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 640, 400
LEFT, RIGHT, TOP, BOTTOM = 70, 180, 40, 60
COLOURS = ("#444444", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")


def steps(low, high, count=5):
    """Round numbers that span low to high."""
    span = max(high - low, 1e-9)
    unit = 10 ** math.floor(math.log10(span / count))
    unit = next(unit * k for k in (1, 2, 5, 10) if span / (unit * k) <= count)
    first = math.floor(low / unit)
    return [round(k * unit, 10) for k in range(first, math.ceil(high / unit) + 1)]


def powers(low, high):
    """1, 2, 5, 10, 20, ... that span low to high."""
    marks = [m * 10.0 ** e for e in range(math.floor(math.log10(low)) - 1, math.ceil(math.log10(high)) + 1) for m in (1, 2, 5)]
    first = max((m for m in marks if m <= low), default=marks[0])
    last = min((m for m in marks if m >= high), default=marks[-1])
    return [m for m in marks if first <= m <= last]


def chart(title, across, up, series):
    """`series`: (name, [(x, y, label)]), x on a logarithmic axis. Points of one series are joined."""
    points = [p for _, ps in series for p in ps]
    xs, ys = powers(min(p[0] for p in points), max(p[0] for p in points)), steps(min(p[1] for p in points), max(p[1] for p in points))
    if len(xs) < 2:
        xs = [xs[0], xs[0] * 2]
    if len(ys) < 2:
        ys = [ys[0], ys[0] + 1]
    inner, tall = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
    place_x = lambda x: LEFT + inner * math.log(x / xs[0]) / math.log(xs[-1] / xs[0])
    place_y = lambda y: TOP + tall * (ys[-1] - y) / (ys[-1] - ys[0])
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="22" font-size="14">{escape(title)}</text>']
    for x in xs:
        out.append(f'<line x1="{place_x(x):.1f}" x2="{place_x(x):.1f}" y1="{TOP}" y2="{TOP + tall}" stroke="#dddddd"/>'
                   f'<text x="{place_x(x):.1f}" y="{TOP + tall + 18}" text-anchor="middle">{x:g}</text>')
    for y in ys:
        out.append(f'<line x1="{LEFT}" x2="{LEFT + inner}" y1="{place_y(y):.1f}" y2="{place_y(y):.1f}" stroke="#dddddd"/>'
                   f'<text x="{LEFT - 8}" y="{place_y(y) + 4:.1f}" text-anchor="end">{y:g}</text>')
    out.append(f'<text x="{LEFT + inner / 2}" y="{HEIGHT - 16}" text-anchor="middle">{escape(across)}</text>')
    out.append(f'<text transform="translate(20 {TOP + tall / 2}) rotate(-90)" text-anchor="middle">{escape(up)}</text>')
    for k, (name, mine) in enumerate(series):
        colour = COLOURS[k % len(COLOURS)]
        way = " ".join(f"{place_x(x):.1f},{place_y(y):.1f}" for x, y, _ in mine)
        out.append(f'<polyline points="{way}" fill="none" stroke="{colour}" stroke-width="2"/>')
        for x, y, label in mine:
            out.append(f'<circle cx="{place_x(x):.1f}" cy="{place_y(y):.1f}" r="3.5" fill="{colour}"/>'
                       f'<text x="{place_x(x) + 5:.1f}" y="{place_y(y) - 5:.1f}" font-size="10" fill="{colour}">{escape(label)}</text>')
        at = TOP + 10 + 18 * k
        out.append(f'<line x1="{WIDTH - RIGHT + 14}" x2="{WIDTH - RIGHT + 36}" y1="{at}" y2="{at}" stroke="{colour}" stroke-width="2"/>'
                   f'<text x="{WIDTH - RIGHT + 42}" y="{at + 4}">{escape(name)}</text>')
    return "\n".join(out + ["</svg>"]) + "\n"
