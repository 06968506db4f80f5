"""stability.json → checked data, and what follows from it: each method's wrong answers of those that it gave, point by point."""
import math
import pathlib

from figures import divide, upper_bound_95
from formats import round_number
from results import FLAG, INVALID, MACHINE, NUMBER, TEXT, ReportError, check, check_names, is_name, parse
from tables import column
from wording import METHODS

POINT = {"rays": NUMBER, "blocked": NUMBER}
SWEEP = {"id": TEXT, "title": TEXT, "parameter": TEXT, "scale": TEXT, "points": [POINT]}
ROOT = {"tool": TEXT, "version": TEXT, "command": TEXT, "machine": MACHINE, "depth": NUMBER, "for_segments": FLAG, "methods": [TEXT], "sweeps": [SWEEP]}
SCALES = ("log", "linear", "category")


def load(folder):
    """The checked sweeps of a folder, or None where none were run."""
    path = pathlib.Path(folder) / "stability.json"
    if not path.exists():
        return None
    data = parse(path)

    def refuse(where, problem):
        raise ReportError(INVALID, f"{path}: {where}: {problem}")

    if not isinstance(data, dict) or data.get("tool") != "vc-bench stability":
        refuse("tool", "these are not results of vc-bench stability")
    check(data, ROOT, "", refuse)
    for key in ("methods", "sweeps"):
        if key not in data:
            refuse(key, "missing")
    for i, method in enumerate(data["methods"]):
        if not is_name(method) or method in data["methods"][:i]:
            refuse(f"methods[{i}]", "expected names, each once")
    for i, sweep in enumerate(data["sweeps"]):
        check_names(sweep, "id", f"sweeps[{i}]", data["sweeps"][:i], refuse)
        if sweep.get("scale") not in SCALES:
            refuse(f"sweeps[{i}].scale", "expected log, linear or category")
        for j, point in enumerate(sweep.setdefault("points", [])):
            check_point(point, sweep["scale"], data["methods"], f"sweeps[{i}].points[{j}]", refuse)
    return data


def check_point(point, scale, methods, where, refuse):
    x = point.get("x")
    if scale == "category":
        if not isinstance(x, str):
            refuse(f"{where}.x", "expected text")
    elif isinstance(x, bool) or not isinstance(x, (int, float)) or not math.isfinite(x) or (scale == "log" and x <= 0):
        refuse(f"{where}.x", "expected a number" + (" above zero" if scale == "log" else ""))
    if "rays" not in point:
        refuse(f"{where}.rays", "missing")
    counts = {"wrong": NUMBER, "resolved": NUMBER}
    check(point, {"refused": {m: TEXT for m in methods}, "results": {m: counts for m in methods}}, where, refuse)
    for method, r in point.setdefault("results", {}).items():
        if method in methods and not (r.keys() >= counts.keys() and r["wrong"] <= r["resolved"] <= point["rays"]):
            refuse(f"{where}.results.{method}", "expected wrong and resolved, no more wrong than resolved, no more resolved than rays")


def label_of(method):
    return METHODS.get(method, method)


def point_row(i, point, methods):
    """One flat row; None is what was not asked, or has no rate because nothing was answered."""
    x = point["x"]
    reasons = {}  # the same reason is said once
    for method in (m for m in methods if m in point.get("refused", {})):
        reasons.setdefault(point["refused"][method], []).append(method)
    row = {"id": f"p{i}", "label": x if isinstance(x, str) else round_number(x), "x": x, "rays": point["rays"],
           "blocked": point.get("blocked"), "refusals": [{"methods": of, "reason": reason} for reason, of in reasons.items()],
           "refused": "; ".join(f"{', '.join(map(label_of, of))}: {reason}" for reason, of in reasons.items()) or None}
    for method in methods:
        r = {} if method in point.get("refused", {}) else point["results"].get(method, {})
        wrong, resolved = r.get("wrong"), r.get("resolved")
        row.update({f"{method}_wrong": wrong, f"{method}_resolved": resolved, f"{method}_rate": divide(wrong, resolved),
                    f"{method}_bound_95": upper_bound_95(wrong, resolved), f"{method}_share": divide(resolved, point["rays"])})
    return row


def place(sweep, row):
    """Where in the sweeps, in words."""
    return f"{sweep['title']}: " + (row["label"] if sweep["scale"] == "category" else f"{sweep['parameter']} = {row['label']}")


def worst(method, sweeps):
    """A method over all sweeps: its totals, its largest wrong rate, and the point with the most wrong answers."""
    rows = [(place(s, r), r) for s in sweeps for r in s["rows"]]
    asked = [(where, r) for where, r in rows if r[f"{method}_resolved"] is not None]
    answered = [(where, r) for where, r in asked if r[f"{method}_resolved"]]
    wrong = [{"where": where, "rate": r[f"{method}_rate"], "wrong": r[f"{method}_wrong"], "resolved": r[f"{method}_resolved"]}
             for where, r in answered if r[f"{method}_wrong"]]
    return {
        "method": method, "label": label_of(method), "points": len(rows), "asked": len(asked), "answered": len(answered),
        "refused": sum(any(method in f["methods"] for f in r["refusals"]) for _, r in rows),
        "wrong": sum(r[f"{method}_wrong"] for _, r in asked), "resolved": sum(r[f"{method}_resolved"] for _, r in asked),
        "worst": max(wrong, key=lambda w: (w["rate"], w["wrong"]), default=None),
        "most": max(wrong, key=lambda w: (w["wrong"], w["rate"]), default=None)}


def tables(stability):
    return [table(sweep, stability["methods"]) for sweep in stability["sweeps"]] if stability else []


def table(sweep, methods):
    columns = [column("rays", "Rays", "count"), column("blocked", "blocked", "count")]
    for m in methods:
        columns += [column(f"{m}_wrong", "wrong", "count", label_of(m)), column(f"{m}_rate", "of answers", "percent", label_of(m))]
        if any(r[f"{m}_share"] not in (None, 1) for r in sweep["rows"]):  # else it answers all that it is asked
            columns.append(column(f"{m}_share", "answered", "percent", label_of(m)))
    rows = [{"id": r["id"], "label": r["label"], **{c["key"]: r[c["key"]] for c in columns}} for r in sweep["rows"]]
    return {"id": f"stability-{sweep['id']}", "caption": f"{sweep['title']} (–: refused, or nothing answered)", "absent": "–", "head": sweep["parameter"], "columns": columns,
            "sections": [{"scene": None, "title": None, "error": None, "rows": rows}]}


def figures_of(folder):
    """What report.json holds of it; None where no sweep was run."""
    data = load(folder)
    if data is None:
        return None
    methods = data["methods"]
    sweeps = [{"id": s["id"], "title": s.get("title", s["id"]), "parameter": s.get("parameter", "x"), "scale": s["scale"],
               "rows": [point_row(i, p, methods) for i, p in enumerate(s["points"])]} for s in data["sweeps"]]
    return {"version": data.get("version"), "command": data.get("command"), "machine": data.get("machine", {}),
            "depth": data.get("depth"), "for_segments": bool(data.get("for_segments")), "methods": methods, "worst": [worst(m, sweeps) for m in methods], "sweeps": sweeps}
