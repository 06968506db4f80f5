"""Each sampled tree of a scene against the proven and the hybrid ones: is one of these at least as fast, with at most as many
wrong rays? Trees that were baked for the scene's own rays do not take part: the sampled ones were not."""
from figures import PROVED, is_for_any_scene, is_sampled
from tables import column

FIGURES = (("speedup", "Speed-up", "ratio"), ("wrong", "Wrong rays", "count"), ("wrong_rate", "Wrong", "percent"))
CLOSEST = "closest proven or hybrid"


def dominates(a, b):
    return a["speedup"] >= b["speedup"] and a["wrong_rate"] <= b["wrong_rate"]


def closest(row, proved):
    """To a tree that nobody dominates: the fastest with no more wrong rays, or else the most exact; and what it lacks."""
    exact = [p for p in proved if p["wrong_rate"] <= row["wrong_rate"]]
    if not exact:
        return min(proved, key=lambda p: (p["wrong_rate"], -p["speedup"])), "more wrong rays"
    other = max(exact, key=lambda p: p["speedup"])
    overlap = other["speedup_high"] >= row["speedup_low"]  # then the order of the medians may be chance
    return other, "slower, within the spread of the repetitions" if overlap else "slower"


def exception(row, proved):
    other, lacks = closest(row, proved)
    return {"id": row["id"], "label": row["label"], **{k: row[k] for k, _, _ in FIGURES}, "closest": other["label"],
            **{f"closest_{k}": other[k] for k, _, _ in FIGURES}, "lacks": lacks}


def of_scene(scene):
    rows = [r for r in scene["variants"] if is_for_any_scene(r) and r["speedup"] is not None and r["wrong_rate"] is not None]
    sampled, proved = [r for r in rows if is_sampled(r)], [r for r in rows if not is_sampled(r)]
    by_method = {m: [p for p in proved if p["method"] == m] for m in PROVED}
    left = [s for s in sampled if not any(dominates(p, s) for p in proved)]
    return {
        "scene": scene["name"], "title": scene["title"], "sampled": len(sampled), "proved": len(proved),
        "dominated": len(sampled) - len(left) if proved else None,
        "dominated_by": {m: sum(any(dominates(p, s) for p in of) for s in sampled) for m, of in by_method.items() if of},
        "exceptions": [exception(s, proved) for s in left] if proved else []}


def all_scenes(scenes):
    return [of_scene(scene) for scene in scenes]


def tables(dominances):
    """One table of all exceptions, or none."""
    columns = [column(k, text, kind, "sampled") for k, text, kind in FIGURES] + [column("closest", "Tree", "text", CLOSEST)]
    columns += [column(f"closest_{k}", text, kind, CLOSEST) for k, text, kind in FIGURES] + [column("lacks", "which is", "text", CLOSEST)]
    sections = [{"scene": d["scene"], "title": d["title"], "error": None, "rows": d["exceptions"]} for d in dominances if d["exceptions"]]
    return [{"id": "dominance", "caption": "Sampled trees that no proven or hybrid one dominates", "head": "Sampled tree",
             "columns": columns, "sections": sections}] if sections else []
