"""Two pictures of a scene under one slider; which two, the reader chooses."""
import base64
import json
from html import escape

from figures import label_of
from formats import show
from results import image_bytes
from wording import NOT_RUN, VIEWS


def collect(folder, scene):
    """[(key, caption, file)] of every picture that the results name, the BVH's first. Reads each file, so that a lost one is
    noticed before anything is written."""
    found = []
    for variant in scene["variants"]:
        if variant["id"] == "unclassified":
            continue
        for view, name in variant.get("images", {}).items():
            if view not in VIEWS:
                continue
            caption = f"{label_of(variant)}: {VIEWS[view]}"
            if view == "difference":
                caption += f" × {variant['difference_factor']}" if "difference_factor" in variant else ""
                caption += f", RMSE {show(variant['rmse'], 'number')}" if "rmse" in variant else ""
                caption += f", largest {show(variant['max_difference'], 'number')}" if "max_difference" in variant else ""
            found.append({"key": f"{variant['id']}/{view}", "variant": variant["id"], "view": view, "caption": caption,
                          "content": image_bytes(folder, name)})
    return found


def first_pair(scene, images):
    """It opens on the BVH's picture beside the one with the most wrong rays: the worst case, not the best."""
    worst = sorted((v for v in scene["variants"] if v["id"] != "bvh"), key=lambda v: -v.get("wrong_rate", -1))
    order = ["bvh/shaded"] + [f"{v['id']}/shaded" for v in worst]
    keys = [image["key"] for image in images]
    chosen = [key for key in order if key in keys] + [key for key in keys if key not in order]
    return chosen[0], chosen[min(1, len(chosen) - 1)]


def data_uri(content):
    return "data:image/png;base64," + base64.b64encode(content).decode()


def options(images, chosen):
    made = ""
    for variant in dict.fromkeys(i["variant"] for i in images):
        of = [i for i in images if i["variant"] == variant]
        inner = ""
        for i in of:
            selected = " selected" if i["key"] == chosen else ""
            inner += f'<option value="{escape(i["key"])}"{selected}>{escape(i["caption"])}</option>'
        made += f'<optgroup label="{escape(of[0]["caption"].split(":")[0])}">{inner}</optgroup>'
    return made


def compare(scene, images, short):
    name, title = scene["name"], escape(scene.get("title", scene["name"]))
    if not images:
        return f'<figure class="compare absent"><strong>{title}</strong><p>{NOT_RUN}</p></figure>'
    left, right = first_pair(scene, images)
    by_key = {i["key"]: i for i in images}
    store = json.dumps({i["key"]: {"caption": i["caption"], "uri": data_uri(i["content"])} for i in images}).replace("<", "\\u003c")

    def side(where, key):
        image = by_key[key]
        return f'<img class="{where}" alt="{title}, {escape(image["caption"])}" src="{data_uri(image["content"])}">'

    def choice(where, key):
        return f'<label>{where} <select class="choose-{where}">{options(images, key)}</select></label>'

    return f'''<figure class="compare" id="compare-{escape(name)}"><h3>{title}</h3>
<div class="choices">{choice("left", left)}{choice("right", right)}</div>
<div class="stage">{side("left", left)}{side("right", right)}<span class="handle" aria-hidden="true"></span></div>
<input type="range" min="0" max="100" value="50" step="1" aria-label="{title}: share of the left picture">
<figcaption><span class="says-left">{escape(by_key[left]["caption"])}</span>
<span class="says-right">{escape(by_key[right]["caption"])}</span></figcaption>
<p class="measured">{escape(short)}</p><script type="application/json" class="store">{store}</script></figure>'''
