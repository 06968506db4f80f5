"""Which points each chart shows. The drawing, the page and a test all take them from here."""
from figures import HIERARCHY, SINGLE, USES, is_configuration, is_hierarchy

EMBREE = "bvh"

LOOK = {
    "speedup": {"x": "wrong_rate", "y": "speedup", "x_scale": "rate", "y_scale": "linear", "y_range": ("speedup_low", "speedup_high"),
                "x_bound": "wrong_bound_95", "area": "memory_bytes",
                "x_label": "wrong shadow rays", "y_label": "speed-up"},
    **{use: {"x": "wrong_rate", "y": "speedup", "x_scale": "rate", "y_scale": "linear", "y_range": ("speedup_low", "speedup_high"),
             "x_bound": "wrong_bound_95", "area": "memory_bytes", "x_label": "wrong shadow rays", "y_label": "speed-up"} for use in USES},
    "bake": {"x": "bake_seconds", "y": "wrong_rate", "x_scale": "log", "y_scale": "rate", "y_bound": "wrong_bound_95",
             "x_label": "bake time, seconds", "y_label": "wrong shadow rays"},
    "memory": {"x": "memory_bytes", "y": "resolved_share", "x_scale": "log", "y_scale": "linear",
               "x_label": "memory of the trees", "y_label": "answered without the BVH"}}


OF_SPEED = ("speedup", *USES)


def point_id(chart, scene, variant):
    return f"point-{chart}-{scene}-{variant}"


OF_THEIR_OWN = {EMBREE: "embree", HIERARCHY: "hierarchy"}  # points that are no tree's


def takes_part(chart, row):
    """Where the answers of hierarchies, or Embree's own, were judged they stand beside those of the trees."""
    return is_configuration(row) or (chart in OF_SPEED and (row["id"] == EMBREE or is_hierarchy(row)))


def scatter(chart, scene):
    """One panel's points, or None where nothing of it was measured."""
    look, points = LOOK[chart], []
    trees = {row["id"]: row for row in scene["variants"]}
    for row in scene[chart] if chart in USES else scene["variants"]:
        if not takes_part(chart, row) or row[look["x"]] is None or row[look["y"]] is None:
            continue
        if any(look[axis + "_scale"] == "log" and row[look[axis]] <= 0 for axis in "xy"):
            continue
        low, high = (row[k] for k in look.get("y_range", (look["y"], look["y"])))
        tree = trees.get(row["behind"], row)
        points.append({
            "id": point_id(chart, scene["name"], row["id"]), "variant": row["id"], "label": row["label"], "behind": row["behind"],
            "method": OF_THEIR_OWN.get(row["id"], tree["method"]), "depth": tree["depth"], "samples": tree["samples"], "demand": tree["demand"], "horizons": row["horizons"], "x": row[look["x"]], "y": row[look["y"]],
            "y_low": low, "y_high": high, "x_bound": row.get(look.get("x_bound")), "y_bound": row.get(look.get("y_bound")),
            "area": tree.get(look.get("area")) if tree["depth"] else None, "wrong_rate": row["wrong_rate"], "wrong_bound_95": row["wrong_bound_95"]})
    if not points:
        return None
    return {"id": f"{chart}-{scene['name']}", "chart": chart, "scene": scene["name"], "title": scene["title"],
            "points": points, "frontier": frontier(points) if chart in OF_SPEED else [],
            "single": next((r["speedup"] for r in scene["variants"] if r["id"] == SINGLE), None) if chart == "speedup" else None,
            **{k: look[k] for k in ("x_label", "y_label", "x_scale", "y_scale")}}


def frontier(points):
    """Variants that no other beats in speed-up and wrong rays at once. Embree itself is one to beat: with its own wrong rays
    where they were judged, else with none."""
    best, chosen = 0.0 if any(p["variant"] == EMBREE for p in points) else 1.0, []
    for p in sorted(points, key=lambda p: (p["x"], -p["y"])):
        if p["y"] > best:
            best = p["y"]
            chosen.append(p["variant"])
    return chosen


def kinds(scene):
    points = [{**{k: row[k] for k in ("kind", "method", "depth", "samples", "label", "lookup_ns", "embree_ns", "embree_ns_minimum",
                                      "embree_ns_maximum", "embree", "share")},
               "id": point_id("kinds", scene["name"], f"{row['id']}-{row['kind']}"), "variant": row["id"],
               "x": row["ns"], "x_low": row["ns_minimum"], "x_high": row["ns_maximum"]}
              for row in scene["kinds"] if row["ns"] and row["embree_ns"] and is_configuration(row)]
    if not points:
        return None
    return {"id": f"kinds-{scene['name']}", "chart": "kinds", "scene": scene["name"], "title": scene["title"],
            "points": points, "x_label": "nanoseconds a segment", "x_scale": "log", "y_scale": "none"}


def all_charts(scenes):
    made = [scatter(chart, scene) for chart in LOOK for scene in scenes] + [kinds(scene) for scene in scenes]
    return [chart for chart in made if chart]
