"""Shapes and colours of the points. Colour says a tree's depth; so does the shape, unless it says proven or hybrid."""
from figures import PROVED
from wording import METHODS

MARKERS = ("o", "s", "^", "D", "v", "P")  # by depth; as many as canvas.py has colours for series
OF_METHOD = {"proven": "*", "hybrid": "X"}
KEY_LINE = 16  # pixels from a row of a key to the next
GROWN = {"*": 1.45, "X": 1.1}  # thin shapes are drawn larger


OF_NO_TREE = {"hierarchy": ("h", "ink"), "embree": ("d", "ink")}


def look(point, depths):
    """(shape, colour) of a tree's point, with Embree or a hierarchy behind it; or of one that is no tree's."""
    if point["method"] in OF_NO_TREE:
        return OF_NO_TREE[point["method"]]
    i = depths.index(point["depth"]) % len(MARKERS)
    return OF_METHOD.get(point["method"], MARKERS[i]), f"c{i}"


OF_SERIES = {"proven": ("*", "c2"), "hybrid": ("X", "c0"), "sampled": ("o", "c1"), "hierarchy": ("^", "c5"),
             "embree": ("s", "c3"), "embree_robust": ("D", "c4")}


def series_look(method, methods):
    """(shape, colour) where a method is a series of its own."""
    return OF_SERIES.get(method, (MARKERS[methods.index(method) % len(MARKERS)], "c5"))


def grown(shape, size):
    return size * GROWN.get(shape, 1)


def without_bvh(point):
    """Drawn hollow."""
    return point["method"] == "hierarchy" or point.get("behind") is not None


def lane(point, points):
    """(which, of how many) lanes of zeros: a method each, so that they do not hide one another; sampled alone has the middle."""
    methods = [m for m in (*PROVED, "sampled", *OF_NO_TREE) if any(p["method"] == m for p in points)]
    return methods.index(point["method"]), len(methods)


def short_name(point):
    """What stands beside a point: the sample rays a cell; proofs take none, so there the depth; "scene" where it was
    baked for one. +H: a hierarchy behind it; +O: and horizons before that."""
    behind = "" if not without_bvh(point) else "+O" if point.get("horizons") else "+H"
    if point["method"] in OF_NO_TREE:
        return {"hierarchy": "H", "embree": "E"}[point["method"]]
    if point.get("demand"):
        return "scene" + behind
    name = f"d{point['depth']}" if point["method"] in PROVED else str(point["samples"])
    return name + behind


def depth_key(canvas, right, y, present, depths):
    """Which colour is which depth, from the right."""
    for depth in reversed(present):
        i = depths.index(depth) % len(MARKERS)
        text = str(depth)
        canvas.text(right, y, text, "muted", 12.5, "right")
        canvas.marker(right - 8 * len(text) - 7, y, MARKERS[i], f"c{i}", 9)
        right -= 7.5 * len(text) + 25
    canvas.text(right + 2, y, "depth", "muted", 12.5, "right")


def series_key(canvas, left, y, right, methods):
    """Row by row, each as long as there is room."""
    at = left
    for method in methods:
        shape, colour = series_look(method, methods)
        text = METHODS.get(method, method)
        length = 20 + 6.9 * len(text)
        if at > left and at + length > right:
            at, y = left, y + KEY_LINE
        canvas.marker(at + 4, y, shape, colour, grown(shape, 7.5))
        canvas.text(at + 11, y, text, "muted", 11.5)
        at += length


def method_key(canvas, left, y, points):
    """The shapes that say a method, of those that are there."""
    for method in (m for m in PROVED if any(p["method"] == m for p in points)):
        shape = OF_METHOD[method]
        canvas.marker(left + 6, y, shape, "muted", grown(shape, 8))
        canvas.text(left + 15, y, method, "muted", 12.5, gid=f"key-{method}")
        left += 26 + 6.5 * len(method)
