"""Small pieces of HTML: escaped text, tables, figures."""
from html import escape

import canvas
from formats import show
from wording import NOT_RUN


def cell(value, kind, absent=NOT_RUN):
    if value is None:
        return f'<td class="none{" text" if kind in ("text", "flag") else ""}">{absent}</td>'
    if kind in ("text", "flag"):
        return f'<td class="text" data-v="{escape(str(value))}">{escape(show(value, kind))}</td>'
    return f'<td data-v="{value!r}">{escape(show(value, kind))}</td>'


def number(value, kind):
    """A figure within a sentence."""
    return f'<span data-v="{value!r}">{escape(show(value, kind))}</span>'


def scrolling(name, inner):
    """A container that scrolls sideways by itself, reachable by keyboard."""
    return f'<div class="scroll" role="region" tabindex="0" aria-label="{escape(name)}">{inner}</div>'


def table(data, folded=False):
    """A table in a container that scrolls by itself; folded: behind a heading that opens it. Its key absent: what stands for None."""
    columns = data["columns"]
    head = f'<th scope="col" rowspan="2" class="head">{escape(data["head"])}</th>' if any(c["group"] for c in columns) else \
           f'<th scope="col" class="head">{escape(data["head"])}</th>'
    top, second = head, ""
    for i, c in enumerate(columns):
        text = ' class="text"' if c["format"] in ("text", "flag") else ""
        if not c["group"]:
            span = ' rowspan="2"' if any(d["group"] for d in columns) else ""
            top += f'<th scope="col"{span}{text}>{escape(c["label"])}</th>'
            continue
        second += f'<th scope="col"{text}>{escape(c["label"])}</th>'
        if i == 0 or columns[i - 1]["group"] != c["group"]:
            span = sum(1 for d in columns if d["group"] == c["group"])
            top += f'<th scope="colgroup" colspan="{span}" class="group">{escape(c["group"])}</th>'
    rows = f"<thead><tr>{top}</tr>{f'<tr>{second}</tr>' if second else ''}</thead>"
    rows += "".join(section(s, columns, data.get("absent", NOT_RUN)) for s in data["sections"])
    caption = f"<caption>{escape(data['caption'])}</caption>"
    whole = scrolling(data["caption"], f'<table id="table-{data["id"]}">{caption}{rows}</table>')
    return f"<details><summary>All figures: {escape(data['caption'])}</summary>{whole}</details>" if folded else whole


def section(data, columns, absent):
    rows = ""
    if data["title"]:
        rows += f'<tr><th scope="rowgroup" colspan="{len(columns) + 1}" class="scene"><span>{escape(data["title"])}</span></th></tr>'
    if not data["rows"]:
        why = f": {data['error']}" if data["error"] else ""
        rows += f'<tr><td colspan="{len(columns) + 1}" class="none text">{NOT_RUN}{escape(why)}</td></tr>'
    for row in data["rows"]:
        cells = "".join(cell(row[c["key"]], c["format"], absent) for c in columns)
        rows += f'<tr data-row="{escape(row["id"])}"><th scope="row">{escape(row["label"])}</th>{cells}</tr>'
    scene = f' data-scene="{escape(data["scene"])}"' if data["scene"] else ""
    return f"<tbody{scene}>{rows}</tbody>"


def panels(charts, kind, scenes, short):
    """One figure a scene; a scene without these figures says so in its place."""
    made = ""
    for scene in scenes:
        chart = next((c for c in charts if c["data"]["chart"] == kind and c["data"]["scene"] == scene["name"]), None)
        if chart:
            made += f'<figure class="panel">{canvas.inline(chart["svg"])}<figcaption>{escape(chart["says"])}</figcaption></figure>'
        else:
            why = f": {scene['error']}" if scene["error"] else "."
            made += f'<figure class="panel absent"><strong>{escape(scene["title"])}</strong><p>{NOT_RUN}{escape(why)}</p></figure>'
    return f'<div class="panels">{made}</div><p class="measured">{escape(short)}</p>'


def definitions(pairs):
    return '<dl class="facts">' + "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(v)}</dd></div>" for k, v in pairs) + "</dl>"
