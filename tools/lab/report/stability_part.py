"""The section on stability: where each method is at its worst, then the panels and tables of each sweep."""
from html import escape

import canvas
import html_parts as parts
from figures import short_setting
from html_parts import number
from stability_data import label_of


def short(stability):
    depth = None if stability["depth"] is None else f"depth {stability['depth']:g}" + (" for the segments" if stability["for_segments"] else "")
    version = f"vcd {stability['version']}" if stability["version"] else None
    return " · ".join(p for p in (stability["command"], version, depth, short_setting({"machine": stability["machine"]})) if p)


def of(w):
    return f"{number(w['wrong'], 'count')} of {number(w['resolved'], 'count')}"


def one(w):
    """A method in one item: its worst rate, and where."""
    if not w["answered"]:
        big, says = "–", "it gave no answer."
    elif not w["worst"]:
        big, says = "none", f"wrong of {number(w['resolved'], 'count')} answers, at {w['answered']} points."
    else:
        big = number(w["worst"]["rate"], "percent")
        says = f"at worst: {escape(w['worst']['where'])}, {of(w['worst'])} answers."
        if w["most"] != w["worst"]:
            says += f" The most: {escape(w['most']['where'])}, {of(w['most'])}."
        says += f" In all {of(w)}, at {w['answered']} points."
    silent = w["asked"] - w["answered"]
    says += f" No answer at {silent}." if silent and w["answered"] else ""
    says += f" Refused at {w['refused']}." if w["refused"] else ""
    return f'<li data-method="{escape(w["method"])}"><b>{escape(w["label"])}</b><span class="big">{big}</span><small>{says}</small></li>'


def refusals(sweep):
    """Each reason once, with its methods and points."""
    grouped = {}
    for row in sweep["rows"]:
        for r in row["refusals"]:
            grouped.setdefault((r["reason"], tuple(r["methods"])), []).append(row["label"])
    return "".join(f'<p class="refused"><b>{escape(", ".join(at))}</b>: refused ({escape(", ".join(map(label_of, methods)))}): {escape(reason)}</p>'
                   for (reason, methods), at in grouped.items())


def panel(sweep, charts, kind):
    found = next((c for c in charts if c["data"]["sweep"] == sweep["id"] and c["data"]["chart"] == kind), None)
    if not found:
        return f'<figure class="panel absent"><strong>{escape(sweep["title"])}</strong><p>No point was measured.</p></figure>'
    return f'<figure class="panel">{canvas.inline(found["svg"])}<figcaption>{escape(found["says"])}</figcaption></figure>'


def all_of(stability, charts, tables):
    """charts: [{data, svg, says}]. tables: id → table. Empty where no sweep was run."""
    if not stability:
        return ""
    sweeps = ""
    for s in stability["sweeps"]:
        sweeps += (f'<article class="sweep" id="sweep-{escape(s["id"])}"><div class="panels">{panel(s, charts, "wrong")}'
                   f'{panel(s, charts, "resolved")}</div><p class="measured">{escape(short(stability))}</p>{refusals(s)}'
                   f'{parts.table(tables["stability-" + s["id"]], folded=True)}</article>')
    items = "".join(one(w) for w in stability["worst"])
    return f'''<section id="stability"><h2>Stability</h2>
<p>One parameter after the other is driven to its extremes, and every answer judged in exact arithmetic. Large: the worst rate of
wrong answers that a method shows at any point of any sweep, of those that it gave; look-ups leave the others to the hierarchy or the BVH,
which have to answer all.</p>
<ul class="summary methods" aria-label="Worst rate of wrong answers, by method">{items}</ul>
<p>In the left panels the rate’s axis is logarithmic down to a grey row, “0 of N”: none wrong of the N rays that the method answered
at that point, which bounds the rate but does not make it zero; a mark’s tooltip has N and the 95 % bound. Where a method answered nothing it has no rate, and where it
refused the mesh no mark at all. All left panels share the rate’s axis.</p>
{sweeps}</section>'''
