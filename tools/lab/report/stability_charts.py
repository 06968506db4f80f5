"""Two panels a sweep: wrong answers as a rate, and the share answered. A parameter that has a scale runs to the right; names
run downwards, one band each, and the values to the right."""
import textwrap
from itertools import pairwise

from axis import SLOT, Axis, tick_mark
from canvas import Canvas
from formats import show
from marks import KEY_LINE, grown, series_key, series_look
from scatter import BOTTOM, HEIGHT, LEFT, RIGHT, WIDTH, broken, frame
from stability_data import label_of

SIZE, KEY_ROW = 7, 57
TOP = 74 + KEY_LINE  # below two rows of the key
NAMES, SUBLANE, BAND_GAP = 134, 7.5, 8  # of the panels with names: their width, and the heights
NONE = "0 of N"
VALUE = {"wrong": ("rate", "rate", "wrong of the rays answered"), "resolved": ("share", "linear", "answered")}


def charts(figures):
    """Every panel of figures_of's sweeps that has a point."""
    if not figures:
        return []
    made = [chart(kind, sweep, figures["methods"]) for sweep in figures["sweeps"] for kind in VALUE]
    return [c for c in made if c["points"]]


def chart(kind, sweep, methods):
    key, scale, label = VALUE[kind]
    name = f"stability-{sweep['id']}-{kind}"
    points = [{"id": f"point-{name}-{i}-{m}", "method": m, "at": i, "label": row["label"], "along": row["x"], "value": row[f"{m}_{key}"],
               **{k: row[f"{m}_{k}"] for k in ("wrong", "resolved", "bound_95")}, "rays": row["rays"]}
              for m in methods for i, row in enumerate(sweep["rows"]) if row[f"{m}_{key}"] is not None]
    refused = [{"at": i, "along": row["x"]} for i, row in enumerate(sweep["rows"]) if row["refusals"]]
    made = {"id": name, "chart": kind, "sweep": sweep["id"], "title": sweep["title"], "methods": methods, "points": points,
            "refused": refused, "names": [r["label"] for r in sweep["rows"]] if sweep["scale"] == "category" else None}
    if made["names"]:
        return {**made, "x_label": label, "y_label": sweep["parameter"], "x_scale": scale, "y_scale": "category"}
    return {**made, "x_label": sweep["parameter"], "y_label": label, "x_scale": sweep["scale"], "y_scale": scale}


def values(group, kind):
    """Of all sweeps, for the axis that they share."""
    return [p["value"] for c in group if c["chart"] == kind for p in c["points"]] if kind == "wrong" else [0, 1]


def draw(chart, group):
    """group: all panels. Returns the canvas and the marks' data."""
    return (draw_names if chart["names"] else draw_scale)(chart, values(group, chart["chart"]))


def draw_scale(chart, shared):
    canvas = Canvas(WIDTH, HEIGHT)
    along = [p["along"] for p in chart["points"] + chart["refused"]]
    x = Axis(chart["x_scale"], along, LEFT, WIDTH - RIGHT, "power")
    y = value_axis(chart, shared, HEIGHT - BOTTOM, TOP)
    data = frame(canvas, chart, x, y, TOP, NONE)
    series_key(canvas, 4, KEY_ROW, WIDTH, chart["methods"])
    for i, gap in enumerate(chart["refused"]):
        at, bottom = x(gap["along"]), HEIGHT - BOTTOM
        first, last = max(at - 7, LEFT), min(at + 7, WIDTH - RIGHT)
        canvas.rectangle(first, TOP, last - first, bottom - TOP, "slot")
        if i == 0 or chart["refused"][i - 1]["at"] < gap["at"] - 1:
            side = "right" if at > WIDTH / 2 else "left"
            canvas.text(last if side == "right" else first, bottom - 0.3 * (bottom - TOP), "refused", "muted", 12, side)
    for lane, method in enumerate(chart["methods"]):
        mine = [(p, x(p["along"]), y(p["value"], lane, len(chart["methods"]))) for p in chart["points"] if p["method"] == method]
        for (a, ax, ay), (b, bx, by) in pairwise(mine):
            if b["at"] == a["at"] + 1:  # else there is a gap between them
                across = y.scale == "rate" and (a["value"] == 0) != (b["value"] == 0)
                canvas.line([ax, bx], [ay, by], series_look(method, chart["methods"])[1], 1.2, zorder=3, alpha=0.7,
                            linestyle=(0, (1, 2)) if across else "-", gid=f"line-{method}-{a['at']}")
        for p, px, py in mine:
            mark(canvas, data, chart, p, px, py, {"x": p["along"], "y": p["value"]})
    return canvas, data


def value_axis(chart, shared, start, end):
    rate = chart["chart"] == "wrong"
    return Axis("rate" if rate else "linear", shared, start, end, "" if rate else "share", tight=True)


def draw_names(chart, shared):
    """A band a name, in it a lane a method."""
    band = SUBLANE * len(chart["methods"]) + BAND_GAP
    bottom = TOP + band * len(chart["names"])
    height, right = bottom + BOTTOM, WIDTH - RIGHT
    canvas, data = Canvas(WIDTH, height), {}
    x = value_axis(chart, shared, NAMES, right)
    canvas.text(4, 14, chart["title"], size=15, weight="bold")
    canvas.text(4, 38, "↓ " + chart["y_label"], "muted", 12.5)
    canvas.text(right, height - 10, chart["x_label"] + " →", "muted", 12.5, "right")
    series_key(canvas, 4, KEY_ROW, WIDTH, chart["methods"])
    if x.scale == "rate":
        canvas.rectangle(NAMES, TOP, SLOT - 6, bottom - TOP, "slot")
    for v in x.ticks:
        canvas.line([x(v), x(v)], [TOP, bottom], "rule", 0.8, zorder=1)

    def tick(axis, value, text, px, py, anchor, size=13):
        gid = f"tick-{chart['id']}-{axis}-{value:g}"
        data[gid] = tick_mark(axis, value)
        canvas.text(px, py, text, "muted" if axis == "x" else "ink", size, anchor, gid=gid)

    for v in x.labelled(44):
        tick("x", v, x.tick_text(v), x(v), bottom + 15, "center")
    if x.scale == "rate":
        broken(canvas, NAMES + SLOT - 3, bottom, upright=False)
        tick("x", 0, NONE, x.zero(), bottom + 15, "center")
    canvas.line([NAMES, right], [bottom, bottom], "muted", 0.8)
    for i, name in enumerate(chart["names"]):
        top = TOP + band * i
        canvas.line([4, right], [top, top], "rule", 0.8, zorder=1)
        lines = textwrap.wrap(name, 18, max_lines=2, placeholder="…")
        for j, line in enumerate(lines):
            tick("y", i + j / 10, line, 4, top + band / 2 + 14 * (j - (len(lines) - 1) / 2), "left", 12)
        if any(g["at"] == i for g in chart["refused"]):
            canvas.text(right, top + band / 2, "refused", "muted", 12, "right")
    for p in chart["points"]:
        lane = chart["methods"].index(p["method"])
        py = TOP + band * p["at"] + BAND_GAP / 2 + SUBLANE * (lane + 0.5)
        mark(canvas, data, chart, p, x(p["value"]), py, {"x": p["value"], "y": p["at"]})
    return canvas, data


def mark(canvas, data, chart, p, px, py, says):
    shape, colour = series_look(p["method"], chart["methods"])
    canvas.marker(px, py, shape, colour, grown(shape, SIZE), gid=p["id"])
    data[p["id"]] = {"class": "point", "data": {**says, "method": p["method"]}, "tip": tip(chart, p)}


def words(chart, p):
    if chart["chart"] == "resolved":
        return f"{show(p['resolved'], 'count')} of {show(p['rays'], 'count')} answered, {show(p['value'], 'percent')}"
    if p["wrong"] == 0:
        return f"none of {show(p['resolved'], 'count')} wrong (95\u00a0% bound {show(p['bound_95'], 'percent')})"
    return f"{show(p['wrong'], 'count')} of {show(p['resolved'], 'count')} wrong, {show(p['value'], 'percent')}"


def tip(chart, p):
    return f"{chart['title']}, {p['label']}, {label_of(p['method'])}: {words(chart, p)}"


def describe(chart):
    return says(chart) + " All figures stand in the table below."


def says(chart):
    """The caption: the worst point, and what N is."""
    if chart["chart"] == "resolved":
        p = min(chart["points"], key=lambda p: p["value"])
        return f"Fewest: {label_of(p['method'])}, {p['label']}: {words(chart, p)}."
    rays = sorted({p["rays"] for p in chart["points"]})
    asked = show(rays[0], "count") if len(rays) == 1 else f"{show(rays[0], 'count')} to {show(rays[-1], 'count')}"
    n = f"N: the rays that a method answered, of {asked} asked."
    p = max(chart["points"], key=lambda p: (p["value"], p["wrong"]))
    return (f"Worst: {label_of(p['method'])}, {p['label']}: {words(chart, p)}. " if p["wrong"] else "No wrong answer seen. ") + n
