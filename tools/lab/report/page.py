"""report.html from the report's figures: one page that needs nothing beside itself."""
import pathlib
from html import escape

import canvas
import dominance_part
import html_parts as parts
import stability_part
import trend_part
from figures import is_configuration, is_hierarchy
from wording import KINDS

HERE = pathlib.Path(__file__).parent
CHART_TITLES = {"speedup": "speed-up against wrong rays", "bake": "bake time against wrong rays",
                "memory": "memory against rays answered", "kinds": "time by kind of segment", "single_calls": "path tracer, single calls", "wavefronts": "path tracer, wavefronts", "wrong": "wrong answers",
                "resolved": "share answered"}


def facts(report):
    s, m = report["settings"], report["machine"]
    memory = f"{m['memory_bytes'] / 2 ** 30:.3g} GiB" if "memory_bytes" in m else None
    image = f"{s['width']} × {s['height']} pixels" if "width" in s and "height" in s else None
    samples = ", ".join(str(s[k]) + t for k, t in (("pixel_samples", " samples a pixel"), ("light_samples", " shadow rays a light")) if k in s)
    timing = ", ".join(t for t in (f"{s['repetitions']} repetitions, interleaved" if "repetitions" in s else "",
                                   f"{s['threads']} threads" if "threads" in s else "", "pinned" if m.get("pinned") else "") if t)
    grid = "; ".join(f"{k} " + ", ".join(map(str, s[k])) for k in ("depths", "samples") if k in s)
    pairs = [("Command", report["command"]), ("Version", f"{report['tool']} {report['version']}" if report["version"] else None),
             ("Profile", s.get("profile")), ("Image", image), ("Rays", samples), ("Configurations", grid), ("Timing", timing),
             ("Seed", str(s["seed"]) if "seed" in s else None), ("Processor", m.get("processor")), ("Memory", memory), ("System", m.get("system")),
             ("Compiler", m.get("compiler")), ("Embree", " ".join(x for x in (m.get("embree"), m.get("embree_isa")) if x) or None)]
    return parts.definitions([(k, v) for k, v in pairs if v])


def summary(scenes):
    """Per scene one sentence, from the figures alone."""
    items = ""
    for scene in scenes:
        rows = [r for r in scene["variants"] if r["speedup"] is not None and (is_configuration(r) or is_hierarchy(r))]
        if not rows:
            why = scene["error"] or "not run"
            items += f'<li><b>{escape(scene["title"])}</b><span class="big none">–</span><small>{escape(why)}</small></li>'
            continue
        best = max(rows, key=lambda r: r["speedup"])
        wrong = "" if best["wrong_rate"] is None else f", {parts.show(best['wrong_rate'], 'percent')} of the shadow rays wrong"
        gain = f'<span class="big" data-v="{best["speedup"]!r}">{parts.show(best["speedup"], "ratio")}</span>'
        items += (f'<li><b>{escape(scene["title"])}</b>{gain}'
                  f'<small>at best: {escape(best["label"])}{wrong}</small></li>')
    return f'<ul class="summary" aria-label="Largest speed-up of shadow rays, by scene">{items}</ul>'


def unclassified_words(scenes):
    items = ""
    for scene in scenes:
        row = next((r for r in scene["variants"] if r["id"] == "unclassified"), None)
        if not row or row["shadow_ratio"] is None:
            items += f"<li>{escape(scene['title'])}: not run.</li>"
            continue
        same = {True: "the image is identical", False: "the image differs: this must not be", None: "the image was not compared"}
        low, middle, high = (parts.show(row[k], "ratio") for k in ("shadow_ratio_low", "shadow_ratio", "shadow_ratio_high"))
        items += (f"<li>{escape(scene['title'])}: shadow rays take {middle} the BVH’s time ({low} to {high}); "
                  f"{same[row['identical_image']]}.</li>")
    return f'<ul class="plain">{items}</ul>'


def build(report, charts, hard, compares):
    """report: what report.json holds. charts, hard (those of stability): [{data, svg, says}]. compares: HTML of the picture sections."""
    scenes, short = report["scenes"], report["short"]
    tables = {t["id"]: t for t in report["tables"]}
    own_axes = report["own_speedup_axes"]
    axes = "Each panel has a vertical axis of its own; the horizontal one is the same for all." if own_axes else "All panels share both axes."

    kinds = "; ".join(f"{name} ({says})" for name, says in KINDS.items())

    def charted(kind):
        return parts.panels(charts, kind, scenes, short) + parts.table(tables[kind], folded=True)

    paper2 = "".join(parts.table(t) for t in report["tables"] if t["id"].startswith("paper-2-"))
    absent = "" if scenes else '<p class="absent">No scene was run.</p>'
    body = f'''<header><h1>Shadow rays with precomputed visibility</h1>
<p class="lead">What vcd sidecars gain, cost and get wrong on the shadow rays of
{len(scenes)} scene{"" if len(scenes) == 1 else "s"}, against the fastest way to ask Embree for the same.</p>
{summary(scenes)}{absent}{facts(report)}{parts.table(tables["scenes"])}</header><main>
<section id="speedup"><h2>Speed-up against wrong rays</h2>
<p>Up is faster, left is more exact. Speed-up counts only the time spent on shadow rays; whiskers reach from the slowest against
the fastest repetition to the reverse. A point’s number is its sample rays a cell; proven and hybrid trees, which have shapes of their own, show their depth (d5)
instead. Filled points leave to Embree what look-ups do not decide; hollow ones leave it to the sidecar’s hierarchy (+H; +O: horizons
are asked before, of what begins on the object), and H has no look-ups at all. Where exact arithmetic judges, Embree itself is a point, E; else wrong means other than
Embree. A tree’s area grows with the square root of its memory. The grey slot at the left is for configurations with no wrong ray seen, whose arrow ends at the 95 % upper
bound. {axes}</p>
{charted("speedup")}{dominance_part.all_of(report["dominance"], tables)}</section>
<section id="paths"><h2>Path tracer</h2>
<p>The shadow rays of paths with up to four bounces, one at each point, to a light or to the sky: against the fastest of Embree’s ways
for the same use. First ray by ray, then as arrays of the rays of 4,096 paths. Embree stays out of all other points: +H leaves to the
hierarchy what look-ups do not decide, +O asks horizons before. Exact arithmetic judges the first rays.</p>
<h3>Single calls</h3>{charted("single_calls")}<h3>Wavefronts</h3>{charted("wavefronts")}</section>
<section id="bake"><h2>Bake time against wrong rays</h2>
<p>What a smaller error costs before rendering. Axes are shared.</p>
{charted("bake")}</section>
<section id="memory"><h2>Memory against rays answered</h2>
<p>The share of shadow rays for which the sidecar knew the answer. The horizontal axis is shared.</p>
{charted("memory")}</section>
<section id="kinds"><h2>By kind of segment</h2>
<p>Segments recorded from the images, one kind at a time. The bar above is the fastest of Embree’s ways on just
these segments; a small hollow mark is the look-up alone, the filled one look-up with Embree as fallback. Left is faster. What stands at the left is the sample rays a cell, or the method.
In the tables the kinds are called {escape(kinds)}.</p>
{charted("kinds")}{parts.table(tables["ways"], folded=True)}{parts.table(tables["image-kinds"], folded=True)}</section>
{stability_part.all_of(report["stability"], hard, tables)}
<section id="pictures"><h2>Pictures</h2>
<p>Each opens on the BVH’s picture and that of the configuration with the most wrong rays.</p>
<div class="compares">{"".join(compares)}</div></section>
<section id="paper"><h2>Beside the paper</h2><p>{escape(report["paper_source"])}. Meshes, cameras, renderer and processor differ
from those of the paper: ratios compare, seconds hardly do. The paper’s BVH was traced ray by ray; here the BVH is asked in packets,
and its time ray by ray has a row of its own.</p>
{parts.table(tables["paper-1"])}{paper2}</section>
<section id="trends"><h2>Trends</h2>
<p>Each statement is checked on every neighbouring pair of sampled configurations, here and on the paper’s own figures.</p>
{trend_part.all_of(report["trends"])}</section>
<section id="unclassified"><h2>The look-up’s own cost</h2>
<p>A sidecar whose cells are all unclassified answers no ray that meets a box: what remains is the cost of asking.</p>
{unclassified_words(scenes)}{parts.table(tables["unclassified"])}<p class="measured">{escape(short)}</p></section></main>'''
    style = (HERE / "page.css").read_text(encoding="utf-8")
    script = (HERE / "page.js").read_text(encoding="utf-8")
    palette = (f":root{{{canvas.variables(0)}--font:{canvas.FONT}}}{canvas.HALO}"
               f"@media screen and (prefers-color-scheme:dark){{:root{{{canvas.variables(1)}}}}}")
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>Shadow rays with precomputed visibility</title>'
            f'<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
            f'<link rel="icon" href="data:,"><style>{palette}\n{style}</style></head><body>{body}<script>{script}</script></body></html>\n')
