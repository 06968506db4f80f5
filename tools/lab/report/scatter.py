"""One panel: a point per configuration; marks.py says its shape and colour, the label its samples."""
import math

from axis import SLOT, Axis, scaled, tick_mark
from canvas import STAND_IN, Canvas
from chart_data import OF_SPEED
from figures import MIB
from formats import show
from marks import depth_key, grown, lane, look, method_key, short_name, without_bvh

WIDTH, HEIGHT = 380, 336
LEFT, RIGHT, TOP, BOTTOM = 66, 24, 60, 50
PLAIN = 9  # diameter of a point whose area says nothing
UNIT = {**{(chart, "y"): "times" for chart in OF_SPEED}, ("memory", "x"): "bytes", ("memory", "y"): "share"}


def extent(charts, axis):
    """All values of one axis, whiskers included. Both ends of a speed-up axis show 1, where nothing is gained."""
    values = [1.0] if charts[0]["chart"] in OF_SPEED and axis == "y" else []
    for p in (p for c in charts for p in c["points"]):
        values += [p[axis], p[f"{axis}_bound"] if p.get(f"{axis}_bound") else p[axis]] if axis == "x" or p.get("y_bound") else []
        if axis == "y":
            values += [c["single"] for c in charts if c.get("single")]
            values += [p["y"], p["y_low"] if p["y_low"] is not None else p["y"], p["y_high"] if p["y_high"] is not None else p["y"]]
    return [scaled(v, UNIT.get((charts[0]["chart"], axis))) for v in values]


def shares_y(charts):
    """Panels share their vertical axis unless that would flatten one of them to a line."""
    spans = [max(v) - min(v) for v in (extent([c], "y") for c in charts)]
    return charts[0]["y_scale"] != "linear" or max(spans) <= 2 * min(spans)


def diameter(area, largest):
    """Area grows with the square root of memory: trees of one run differ by a factor of some hundred."""
    return PLAIN if not area or not largest else max(5.0, 26 * (area / largest) ** 0.25)


def draw(chart, group, depths):
    """group: all panels of this kind, for the axes that they share. Returns the canvas and the marks' data."""
    canvas = Canvas(WIDTH, HEIGHT)
    kind = chart["chart"]
    own = group if shares_y(group) else [chart]
    x = Axis(chart["x_scale"], extent(group, "x"), LEFT, WIDTH - RIGHT, UNIT.get((kind, "x"), ""))
    y = Axis(chart["y_scale"], extent(own, "y"), HEIGHT - BOTTOM, TOP, UNIT.get((kind, "y"), ""))
    data = frame(canvas, chart, x, y)
    depth_key(canvas, WIDTH - RIGHT, 14, sorted({p["depth"] for p in chart["points"]} - {None}), depths)
    method_key(canvas, 4, HEIGHT - 10, chart["points"])
    if kind in OF_SPEED:
        reference(canvas, chart, x, y)
    largest = max((p["area"] or 0 for c in group for p in c["points"]), default=0)
    placed, spots = [], []
    for p in sorted(chart["points"], key=lambda p: -(p["area"] or 0)):
        px, py = (axis(scaled(p[k], axis.unit), *lane(p, chart["points"])) for k, axis in (("x", x), ("y", y)))
        shape, colour = look(p, depths)
        size = grown(shape, diameter(p["area"], largest))
        whiskers(canvas, p, px, py, x, y, colour, size)
        canvas.marker(px, py, shape, colour, size, gid=p["id"], alpha=0.85, filled=not without_bvh(p))
        data[p["id"]] = {"class": "point", "data": {"x": p["x"], "y": p["y"], "variant": p["variant"], "method": p["method"]}, "tip": tip(chart, p)}
        spots.append((px, py, size, p))
    for px, py, size, p in spots:
        place_label(canvas, px, py, size, short_name(p), p["x"] == 0, [(a, b, s) for a, b, s, _ in spots], placed)
    return canvas, data


def frame(canvas, chart, x, y, top=TOP, zero="0 seen"):
    """Title, axes, grid; zero: what stands at that of a rate. Returns the marks' data of the ticks' labels."""
    ticks = {}

    def tick(axis, value, text, px, py, anchor):
        gid = f"tick-{chart['id']}-{axis}-{value:g}"
        unit = MIB if (x if axis == "x" else y).unit == "bytes" else 1
        ticks[gid] = tick_mark(axis, value * unit)
        canvas.text(px, py, text, "muted", 13, anchor, gid=gid)

    canvas.text(4, 14, chart["title"], size=15, weight="bold")
    canvas.text(4, 38, "↑ " + chart["y_label"], "muted", 12.5)
    unit = ", MiB" if x.unit == "bytes" else ""
    canvas.text(WIDTH - RIGHT, HEIGHT - 10, chart["x_label"] + unit + " →", "muted", 12.5, "right")
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    if x.scale == "rate":
        canvas.rectangle(LEFT, top, SLOT - 6, bottom - top, "slot")
    if y.scale == "rate":
        canvas.rectangle(LEFT, bottom - SLOT + 6, right - LEFT, SLOT - 6, "slot")
    for v in y.ticks:
        canvas.line([LEFT, right], [y(v), y(v)], "rule", 0.8, zorder=1)
    for v in x.ticks:
        canvas.line([x(v), x(v)], [bottom, bottom + 4], "muted", 0.8)
    for v in x.labelled(46):
        tick("x", v, x.tick_text(v), x(v), bottom + 15, "center")
    for v in y.labelled(18):
        tick("y", v, y.tick_text(v), LEFT - 6, y(v), "right")
    canvas.line([LEFT, right], [bottom, bottom], "muted", 0.8)
    if x.scale == "rate":
        broken(canvas, LEFT + SLOT - 3, bottom, upright=False)
        tick("x", 0, zero, x.zero(), bottom + 15, "center")
    if y.scale == "rate":
        canvas.line([LEFT, LEFT], [top, bottom], "muted", 0.8)
        broken(canvas, LEFT, bottom - SLOT + 3, upright=True)
        tick("y", 0, zero, LEFT - 6, y.zero(), "right")
    return ticks


def broken(canvas, px, py, upright):
    """The gap that says: here the axis is no longer logarithmic."""
    if upright:
        canvas.line([px, px], [py - 3, py + 3], "ground", 3, zorder=3)
        for d in (-3, 3):
            canvas.line([px - 4, px + 4], [py + d + 2, py + d - 2], "muted", 0.9, zorder=4)
    else:
        canvas.line([px - 3, px + 3], [py, py], "ground", 3, zorder=3)
        for d in (-3, 3):
            canvas.line([px + d - 2, px + d + 2], [py + 4, py - 4], "muted", 0.9, zorder=4)


def reference(canvas, chart, x, y):
    """Embree's own line at 1, and the frontier as steps: up to each corner the best that this error buys."""
    right = WIDTH - RIGHT
    canvas.line([LEFT, right], [y(1), y(1)], "ink", 1.1, zorder=2)
    canvas.line([right - 200, right - 184], [38, 38], "ink", 1.1)
    canvas.text(right - 179, 38, "Embree", "muted", 12.5)
    canvas.line([right - 118, right - 100], [38, 38], "frontier", 1.4, linestyle=(0, (4, 2.5)))
    canvas.text(right, 38, "Pareto frontier", "muted", 12.5, "right")
    if chart["single"]:
        canvas.line([LEFT, right], [y(chart["single"])] * 2, "muted", 1, gid=f"single-{chart['id']}", linestyle=(0, (1, 2)), zorder=2)
        canvas.text(right, y(chart["single"]) + 9, "Embree, ray by ray", "muted", 12, "right")
    best = {p["variant"]: p for p in chart["points"]}
    corners = [best[v] for v in chart["frontier"]]
    judged = any(p["method"] == "embree" for p in chart["points"])  # else it is the first corner, with no wrong ray
    xs, ys = ([x(corners[0]["x"], *lane(corners[0], chart["points"]))], [y(corners[0]["y"])]) if judged else ([LEFT], [y(1)])
    for p in corners:
        xs += [x(p["x"], *lane(p, chart["points"]))] * 2
        ys += [ys[-1], y(p["y"])]
    if corners:
        canvas.line([*xs, right], [*ys, ys[-1]], "frontier", 1.4, gid=f"frontier-{chart['id']}", linestyle=(0, (4, 2.5)), zorder=2)


def whiskers(canvas, p, px, py, x, y, colour, size):
    if p["y_low"] is not None and p["y_low"] != p["y_high"]:
        canvas.line([px, px], [y(p["y_low"]), y(p["y_high"])], colour, 1.2, zorder=3)
    if p["x_bound"] and p["x_bound"] > p["x"]:
        reach(canvas, px, py, x(p["x_bound"]), py, colour, p["x"] == 0)
    if p["y_bound"] and p["y_bound"] > p["y"]:
        reach(canvas, px, py, px, y(p["y_bound"]), colour, p["y"] == 0)


def reach(canvas, x0, y0, x1, y1, colour, arrow):
    """From what was seen to the 95 % bound; an arrow where nothing was seen."""
    canvas.line([x0, x1], [y0, y1], colour, 1.2, zorder=3)
    if arrow:
        shape = ">" if y0 == y1 else "^"
        canvas.axes.plot([x1], [y1], marker=shape, markersize=5, color=STAND_IN[colour], linestyle="none", clip_on=False, zorder=4)


def place_label(canvas, px, py, size, text, arrow, spots, placed):
    """The first of several places around the point that covers no other point and no other label."""
    width, height, gap = 7.4 * len(text), 13, size / 2 + 3
    places = [(px + gap + width / 2, py), (px, py - gap - height / 2 + 2), (px, py + gap + height / 2 - 1), (px - gap - width / 2, py),
              (px + gap + width / 2 - 2, py - gap + 1), (px + gap + width / 2 - 2, py + gap - 1),
              (px - gap - width / 2 + 2, py - gap + 1), (px - gap - width / 2 + 2, py + gap - 1)]

    if arrow:  # it leaves to the right
        places = places[4:6] + places[:4] + places[6:]

    away = lambda a, b, reach: b + (b > a) * reach - (b < a) * reach
    places += [(away(px, cx, reach), away(py, cy, reach)) for reach in (14, 28) for cx, cy in places]

    def cost(place):
        cx, cy = place
        hits = sum(1.0 for a, b, s in spots if abs(a - cx) < (width + s) / 2 and abs(b - cy) < (height + s) / 2 - 2)
        hits += sum(1.5 for a, b, w in placed if abs(a - cx) < (width + w) / 2 and abs(b - cy) < height - 1)
        outside = cx + width / 2 > WIDTH - 2 or cx - width / 2 < LEFT or cy < TOP - 6 or cy > HEIGHT - BOTTOM - 5
        return hits + 3 * outside + math.hypot(cx - px, cy - py) / 1000  # of two that are free, the nearer

    cx, cy = min(places, key=cost)
    placed.append((cx, cy, width))
    canvas.text(cx, cy, text, "ink", 12, "center")


def words(chart, p):
    """The two figures of a point, as they are said aloud."""
    if chart["chart"] == "memory":
        return f"{show(p['x'], 'mib')}\u00a0MiB, {show(p['y'], 'percent')} answered"
    rate = "no wrong ray seen" if p["wrong_rate"] == 0 else f"{show(p['wrong_rate'], 'percent')} wrong"
    if p["wrong_bound_95"]:
        rate += f" (95\u00a0% bound {show(p['wrong_bound_95'], 'percent')})"
    gain = f"{show(p['y'], 'ratio')}" if chart["chart"] in OF_SPEED else f"{show(p['x'], 'seconds')}\u00a0s"
    return f"{gain}, {rate}"


def tip(chart, p):
    return f"{chart['title']}, {p['label']}: {words(chart, p)}"


def describe(chart):
    """What a reader who does not see the picture needs."""
    return "; ".join(f"{p['label']}: {words(chart, p)}" for p in chart["points"]) + ". The same figures stand in the table below."


def says(chart):
    """The caption: the panel's ends, in words."""
    points = chart["points"]
    if chart["chart"] in OF_SPEED:
        first, last = max(points, key=lambda p: p["y"]), min(points, key=lambda p: (p["x"], -p["y"]))
        heads = "Fastest", "Fewest wrong"
    else:
        first, last = min(points, key=lambda p: p["x"]), max(points, key=lambda p: p["x"])
        heads = ("Shortest", "Longest") if chart["chart"] == "bake" else ("Smallest", "Largest")
    ends = [(heads[0], first)] + ([(heads[1], last)] if last is not first else [])
    return " ".join(f"{head}: {p['label']}: {words(chart, p)}." for head, p in ends)
