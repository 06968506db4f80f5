"""The chart by kind of segment: fastest Embree above, then look-up → look-up with fallback, one lane a configuration."""
from axis import Axis, tick_mark
from canvas import Canvas
from figures import PROVED
from formats import show
from marks import depth_key, grown, look, method_key
from wording import KINDS

WIDTH, LEFT, RIGHT, TOP = 380, 56, 24, 44
LANE, HEAD, EMBREE, GAP, BOTTOM = 8.5, 22, 16, 12, 48


def draw(chart, group, depths):
    points = chart["points"]
    kinds = list(dict.fromkeys(p["kind"] for p in points))
    by_kind = {k: sorted((p for p in points if p["kind"] == k), key=lambda p: (order(p), p["depth"])) for k in kinds}
    height = TOP + BOTTOM + sum(HEAD + EMBREE + GAP + LANE * len(by_kind[k]) + 3 * len({group_name(p) for p in by_kind[k]}) for k in kinds)
    canvas, data = Canvas(WIDTH, height), {}
    values = [v for c in group for p in c["points"] for v in (p["x"], p["lookup_ns"], p["embree_ns"], p["x_high"]) if v]
    x = Axis("log", values, LEFT, WIDTH - RIGHT)
    canvas.text(4, 14, chart["title"], size=15, weight="bold")
    canvas.text(WIDTH - RIGHT, height - 10, chart["x_label"] + " →", "muted", 12.5, "right")
    depth_key(canvas, WIDTH - RIGHT, 14, sorted({p["depth"] for p in points}), depths)
    method_key(canvas, 4, height - 10, points)
    bottom = height - BOTTOM + 6
    for v in x.ticks:
        canvas.line([x(v), x(v)], [TOP - 8, bottom], "rule", 0.8, zorder=1)
    for v in x.labelled(40):
        gid = f"tick-{chart['id']}-x-{v:g}"
        data[gid] = tick_mark("x", v)
        canvas.text(x(v), bottom + 11, x.tick_text(v), "muted", 13, "center", gid=gid)
    y = TOP
    for kind in kinds:
        y = band(canvas, kind, by_kind[kind], x, y, depths, data, chart)
    return canvas, data


def band(canvas, kind, points, x, y, depths, data, chart):
    share = points[0]["share"]
    title = KINDS.get(kind, kind) + (f", {share * 100:.3g} % of the rays" if share is not None else "")
    canvas.text(4, y + 6, title, size=13)
    y += HEAD
    first = points[0]
    canvas.line([x(first["embree_ns_minimum"]), x(first["embree_ns_maximum"])], [y + 3, y + 3], "ink", 1.6)
    canvas.marker(x(first["embree_ns"]), y + 3, "|", "ink", 12, filled=False)
    canvas.line([x(first["embree_ns"])] * 2, [y + 3, y + EMBREE + LANE * len(points) + 4], "ink", 0.8, linestyle=(0, (1.5, 2)), zorder=2)
    canvas.text(LEFT - 6, y + 3, "Embree", "ink", 12, "right")
    y += EMBREE
    name = None
    for i, p in enumerate(points):
        if group_name(p) != name:
            name, same = group_name(p), sum(group_name(q) == group_name(p) for q in points)
            y += 3 if i else 0
            canvas.text(LEFT - 6, y + LANE * (same - 1) / 2 + 1, name, "muted", 12, "right")
        shape, colour = look(p, depths)
        if p["lookup_ns"]:
            canvas.line([x(p["lookup_ns"]), x(p["x"])], [y, y], colour, 1.0, zorder=3, alpha=0.6)
            canvas.marker(x(p["lookup_ns"]), y, shape, colour, grown(shape, 4), filled=False)
        canvas.marker(x(p["x"]), y, shape, colour, grown(shape, 7.5), gid=p["id"])
        data[p["id"]] = {"class": "point", "data": {"x": p["x"], "variant": p["variant"], "kind": kind}, "tip": tip(p)}
        y += LANE
    return y + GAP + 3


def order(p):
    """Sampled trees first, by their samples."""
    return (1, PROVED.index(p["method"])) if p["method"] in PROVED else (0, p["samples"])


def group_name(p):
    return p["method"] if p["method"] in PROVED else str(p["samples"])


def tip(p):
    look_up = f", {show(p['lookup_ns'], 'ns')} ns the look-up alone" if p["lookup_ns"] else ""
    return f"{KINDS.get(p['kind'], p['kind'])}, {p['label']}: {show(p['x'], 'ns')} ns{look_up}; {p['embree']} {show(p['embree_ns'], 'ns')} ns"


def describe(chart):
    return says(chart) + " All figures stand in the table below."


def says(chart):
    ratios = [(p["embree_ns"] / p["x"], p) for p in chart["points"]]
    (low, worst), (high, best) = min(ratios, key=lambda r: r[0]), max(ratios, key=lambda r: r[0])
    return (f"From {show(low, 'ratio')} Embree’s speed ({KINDS.get(worst['kind'], worst['kind'])}; {worst['label']}) "
            f"to {show(high, 'ratio')} ({KINDS.get(best['kind'], best['kind'])}; {best['label']}).")
