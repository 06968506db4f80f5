"""The section that holds the paper's statements against the measurements."""
from html import escape

from html_parts import number, scrolling
from wording import NOT_RUN


def pair(values, kind):
    return NOT_RUN if values is None else f"{number(values[0], kind)} → {number(values[1], kind)}"


def header(*columns):
    """columns: (text, class)"""
    cells = "".join(f'<th scope="col"{f" class={kind}" if kind else ""}>{escape(text)}</th>' for text, kind in columns)
    return f"<thead><tr>{cells}</tr></thead>"


def deviations(trend, scene):
    """Each step that goes the other way, here or in the paper, with both figures."""
    words = {"yes": "yes", "no": "no", "unclear": "unclear", None: "–"}
    unit = {"mib": ", MiB", "seconds": ", s"}.get(trend["format"], "")
    rows = ""
    for s in scene["deviations"]:
        there = pair(s["paper"], trend["format"]) if s["paper"] else "–"
        rows += (f'<tr><th scope="row">{escape(s["what"])}</th><td>{pair(s["here"], trend["format"])}</td>'
                 f'<td class="text">{words[s["here_holds"]]}</td><td>{there}</td><td class="text">{words[s["paper_holds"]]}</td></tr>')
    name = f"{scene['title']}: steps that go the other way"
    head = header(("Step", "head"), ("here" + unit, ""), ("holds", "text"), ("paper" + unit, ""), ("holds", "text"))
    return scrolling(name, f"<table><caption>{escape(name)}</caption>{head}<tbody>{rows}</tbody></table>")


def one(trend):
    rows = ""
    for s in trend["scenes"]:
        there = f'{s["held_paper"]} of {s["steps_paper"]}' if s["steps_paper"] else "–"
        here = f'{s["held_here"]} of {s["steps"]}' if s["steps"] else NOT_RUN
        state = "none" if not s["steps"] else "good" if s["held_here"] == s["steps"] else "open"
        rows += (f'<tr data-scene="{escape(s["scene"])}"><th scope="row">{escape(s["title"])}</th><td>{here}</td><td>{there}</td>'
                 f'<td class="text verdict {state}">{escape(s["verdict"])}</td></tr>')
    if not rows:
        rows = f'<tr><td colspan="4" class="none text">{NOT_RUN}</td></tr>'
    head = header(("Scene", "head"), ("steps, here", ""), ("steps, paper", ""), ("Verdict", "text"))
    caption = f'<caption class="unseen">{escape(trend["sentence"])}</caption>'
    body = scrolling(trend["sentence"], f"<table>{caption}{head}<tbody>{rows}</tbody></table>")
    remark = f'<p class="remark">{escape(trend["remark"])}</p>' if trend["remark"] else ""
    details = "".join(deviations(trend, s) for s in trend["scenes"] if s["deviations"])
    if details:
        details = f"<details><summary>Steps that go the other way, both figures</summary>{details}</details>"
    return f'<article class="trend" id="trend-{trend["id"]}"><h3>{escape(trend["sentence"])}</h3>{body}{remark}{details}</article>'


def all_of(trends):
    return '<div class="trends">' + "".join(one(t) for t in trends) + "</div>"
