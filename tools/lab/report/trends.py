"""What the paper says of its own figures, checked step by step on ours and on theirs."""
from figures import is_sampled
from paper_tables import in_our_unit

SIMPLE, COMPLEX = ("killeroo", "sierpinski"), ("hairball", "forest")
# id, sentence, our key, the paper's key, what changes from step to step, direction, format
TRENDS = [
    ("error-falls-with-samples", "Wrong rays fall with more samples.", "wrong_rate", "error_percent", "samples", -1, "percent"),
    ("tests-fall-with-depth", "Ray-triangle tests fall with depth.", "tests", "tests_millions", "depth", -1, "count"),
    ("render-falls-with-depth", "Render time falls with depth.", "render_seconds", "render_seconds", "depth", -1, "seconds"),
    ("memory-grows-with-depth", "Memory grows with depth.", "memory_bytes", "memory_mib", "depth", 1, "mib"),
    ("memory-grows-with-samples", "Memory grows with samples.", "memory_bytes", "memory_mib", "samples", 1, "mib"),
    ("build-grows-with-depth", "Build time grows with depth.", "bake_seconds", "build_seconds", "depth", 1, "seconds"),
    ("build-grows-with-samples", "Build time grows with samples.", "bake_seconds", "build_seconds", "samples", 1, "seconds")]
GAIN = "gain-larger-on-complex"


def right(pair, direction):
    """Strictly so, except that what is zero cannot fall."""
    first, second = pair
    return (second - first) * direction > 0 or (direction < 0 and first == second == 0)


def overlap(a, b, key):
    """Do the repetitions of two timings overlap? Then their medians' order says nothing."""
    keys = (f"{key}_minimum", f"{key}_maximum")
    return all(r.get(k) is not None for r in (a, b) for k in keys) and a[keys[0]] <= b[keys[1]] and b[keys[0]] <= a[keys[1]]


def step(what, here, paper, direction, near=False):
    """here, paper: (before, after); paper may be None."""
    holds = "yes" if right(here, direction) else "unclear" if near else "no"
    return {"what": what, "here": list(here), "paper": list(paper) if paper else None, "here_holds": holds,
            "paper_holds": ("yes" if right(paper, direction) else "no") if paper else None}


def scene_steps(scene, paper, trend):
    _, _, ours, theirs, moving, direction, _ = trend
    fixed = "samples" if moving == "depth" else "depth"
    entries = paper["table2"].get(scene["name"], {})
    rows = [r for r in scene["variants"] if is_sampled(r) and r[ours] is not None]
    steps = []
    for value in sorted({r[fixed] for r in rows}):
        line = sorted((r for r in rows if r[fixed] == value), key=lambda r: r[moving])
        for a, b in zip(line, line[1:]):
            there = [in_our_unit(entries.get(r["id"]), theirs) for r in (a, b)]
            what = f"{fixed} {value}, {moving} {a[moving]} → {b[moving]}"
            steps.append(step(what, (a[ours], b[ours]), None if None in there else there, direction, overlap(a, b, ours)))
    return steps


def gain_steps(scene, simple_scenes, paper):
    """Does each configuration gain more here than on the simple scenes? Gain: the BVH's render time over ours."""
    steps = []
    for simple in simple_scenes:
        other = {r["id"]: r for r in simple["variants"]}
        for row in scene["variants"]:
            if not is_sampled(row) or not row["render_ratio"] or not other.get(row["id"], {}).get("render_ratio"):
                continue
            entries = [paper["table2"].get(s["name"], {}) for s in (simple, scene)]
            there = [e["bvh"]["render_seconds"] / e[row["id"]]["render_seconds"] if row["id"] in e else None for e in entries]
            steps.append(step(f"{row['label']}: {simple['title']} → {scene['title']}",
                              (1 / other[row["id"]]["render_ratio"], 1 / row["render_ratio"]), None if None in there else there, 1))
    return steps


def verdict(steps):
    if not steps:
        return "not run"
    here = [s["here_holds"] for s in steps]
    there = [s["paper_holds"] for s in steps if s["paper_holds"]]
    holds_there = bool(there) and all(h == "yes" for h in there)
    if all(h == "yes" for h in here):
        if not there:
            return "holds; the paper does not have this scene"
        return "holds, as in the paper" if holds_there else "holds here, not in every step in the paper"
    if "no" not in here:
        return "unclear: some steps lie within the spread of the repetitions"
    if not there:
        return "does not hold here; the paper does not have this scene"
    return "does not hold here; it does in the paper" if holds_there else "holds in every step neither here nor in the paper"


def summary(scene, steps):
    return {"scene": scene["name"], "title": scene["title"], "verdict": verdict(steps), "steps": len(steps),
            "held_here": sum(s["here_holds"] == "yes" for s in steps), "held_paper": sum(s["paper_holds"] == "yes" for s in steps),
            "steps_paper": sum(s["paper_holds"] is not None for s in steps),
            "deviations": [s for s in steps if s["here_holds"] != "yes" or s["paper_holds"] == "no"]}


def all_trends(scenes, paper, remarks):
    trends = []
    for trend in TRENDS:
        trends.append({"id": trend[0], "sentence": trend[1], "format": trend[6],
                       "scenes": [summary(s, scene_steps(s, paper, trend)) for s in scenes]})
    simple = [s for s in scenes if s["name"] in SIMPLE]
    trends.insert(3, {"id": GAIN, "sentence": "Hair and foliage gain more than simple geometry.", "format": "ratio",
                      "scenes": [summary(s, gain_steps(s, simple, paper)) for s in scenes if s["name"] in COMPLEX]})
    for trend in trends:
        deviates = any(s["held_here"] < s["steps"] for s in trend["scenes"])
        trend["deviates"] = deviates
        # The remarks were written about the paper's scenes.
        explained = any(s["held_here"] < s["steps"] and s["scene"] in paper["table2"] for s in trend["scenes"])
        trend["remark"] = remarks.get(trend["id"]) if explained else None
    return trends
