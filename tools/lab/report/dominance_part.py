"""What the page says of proven and hybrid trees against sampled ones."""
from html import escape

from html_parts import number, table


def sentence(d):
    if not d["sampled"] or not d["proved"]:
        missing = "proven or hybrid" if d["sampled"] else "sampled" if d["proved"] else "sampled, proven or hybrid"
        return f"no {missing} tree was timed and counted."
    each = ", ".join(f"{number(count, 'count')} by a {method} one" for method, count in d["dominated_by"].items())
    sampled = number(d["sampled"], "count")
    if d["dominated"] == d["sampled"]:
        return f"proven and hybrid trees dominate every sampled tree: of {sampled}, {each}."
    if not d["dominated"]:
        return f"proven and hybrid trees dominate none of {sampled} sampled trees."
    names = "; ".join(escape(e["label"]) for e in d["exceptions"])
    return f"proven and hybrid trees dominate {number(d['dominated'], 'count')} of {sampled} sampled trees ({each}), and not: {names}."


def all_of(dominances, tables):
    """tables: id → table."""
    items = "".join(f'<li data-scene="{escape(d["scene"])}"><b>{escape(d["title"])}</b>: {sentence(d)}</li>' for d in dominances)
    exceptions = table(tables["dominance"]) if "dominance" in tables else ""
    return (f'<h3>Proven and hybrid against sampled</h3><p>A tree dominates another if it is at least as fast, by medians, and gives '
            f'at most as many wrong rays.</p><ul class="plain dominance">{items}</ul>{exceptions}')
