"""A matplotlib figure measured in CSS pixels, whose SVG takes its colours from CSS variables.

The drawing uses stand-in colours; finish() swaps them for var(--name), so that one file serves light and dark.
"""
import io
import re
import xml.etree.ElementTree as ET

import matplotlib

matplotlib.use("svg")
from matplotlib.figure import Figure  # noqa: E402 (the backend comes first)
from matplotlib.patches import Rectangle  # noqa: E402

SVG, XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
ET.register_namespace("", SVG)
ET.register_namespace("xlink", XLINK)

# name → light, dark. c0…: Okabe and Ito's colours, told apart by the colour-blind too, each legible on its ground.
COLOURS = {
    "ink": ("#1b1f24", "#e8e6e1"), "muted": ("#5d6670", "#a2a8b0"), "rule": ("#d9dce0", "#363c44"),
    "ground": ("#ffffff", "#15181c"), "slot": ("#f1f2f4", "#20252b"), "frontier": ("#8b939c", "#7b848e"),
    "c0": ("#0072b2", "#56b4e9"), "c1": ("#d55e00", "#e69f00"), "c2": ("#008a65", "#00b586"),
    "c3": ("#b0588c", "#cc79a7"), "c4": ("#8a7a00", "#f0e442"), "c5": ("#000000", "#ffffff")}
STAND_IN = {name: f"#fe{i:02x}01" for i, name in enumerate(COLOURS)}
HALO = "svg text{paint-order:stroke;stroke:var(--ground);stroke-width:3px;stroke-linejoin:round}"  # legible on lines
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"

matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "vcd", "font.family": "DejaVu Sans", "path.simplify": False})


def variables(dark):
    return "".join(f"--{name}:{pair[dark]};" for name, pair in COLOURS.items())


class Canvas:
    """Pixel coordinates with y downwards; every mark may carry an element id."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self.figure = Figure(figsize=(width / 72, height / 72), dpi=72)
        self.figure.patch.set_visible(False)
        self.axes = self.figure.add_axes([0, 0, 1, 1])
        self.axes.set_axis_off()
        self.axes.set_xlim(0, width)
        self.axes.set_ylim(height, 0)
        self.axes.set_autoscale_on(False)

    def line(self, xs, ys, colour, width=1.0, gid=None, **more):
        return self.axes.plot(xs, ys, color=STAND_IN[colour], linewidth=width, gid=gid, clip_on=False, **more)[0]

    def rectangle(self, x, y, width, height, colour):
        self.axes.add_patch(Rectangle((x, y), width, height, facecolor=STAND_IN[colour], edgecolor="none", zorder=0))

    def marker(self, x, y, shape, colour, size, gid=None, filled=True, alpha=1.0, zorder=5):
        """size: diameter in pixels."""
        ring = STAND_IN["ground" if filled else colour]
        self.axes.plot([x], [y], marker=shape, linestyle="none", markersize=size, gid=gid, clip_on=False, alpha=alpha,
                       markerfacecolor=STAND_IN[colour if filled else "ground"], markeredgecolor=ring,
                       markeredgewidth=1.0 if filled else 1.4, zorder=zorder)

    def text(self, x, y, text, colour="ink", size=12, anchor="left", weight="normal", gid=None):
        self.axes.text(x, y, text.replace("$", r"\$"), color=STAND_IN[colour], fontsize=size, ha=anchor, va="center",
                       fontweight=weight, gid=gid, zorder=8)

    def finish(self, name, title, description, data, scales):
        """The SVG element: themed, labelled, without dates; data: element id → class, attributes and tooltip."""
        buffer = io.BytesIO()
        self.figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
        text = buffer.getvalue().decode()
        for colour, stand_in in STAND_IN.items():
            text = text.replace(stand_in, f"var(--{colour})")
        text = re.sub(r"font: (?:(bold|\d+) )?([\d.]+px)[^;\"]*", lambda m: f"font-size: {m[2]}; font-weight: {m[1] or 400}", text)
        root = ET.fromstring(text)
        strip(root)
        rename(root, name, set(data))
        for element in list(root.iter()):
            mark = data.get(element.get("id"))
            if mark:
                element.set("class", mark["class"])
                for key, value in mark["data"].items():
                    element.set(f"data-{key}", str(value))
                if mark["tip"]:
                    tip = ET.Element(f"{{{SVG}}}title")
                    tip.text = mark["tip"]
                    element.insert(0, tip)
        label(root, name, title, description, self.width, self.height)
        for key, value in scales.items():
            root.set(key, value)
        return root


def strip(root):
    """Metadata, and the style sheet that would reach the whole page."""
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag == f"{{{SVG}}}metadata" or child.tag == f"{{{SVG}}}style":
                parent.remove(child)
        if parent.tag == f"{{{SVG}}}defs" and len(parent) == 0:
            parent.set("class", "empty")


def rename(root, prefix, kept):
    """Ids become unique in a page of many charts."""
    for element in root.iter():
        if element.get("id") and element.get("id") not in kept:
            element.set("id", f"{prefix}--{element.get('id')}")
        for key, value in element.attrib.items():
            if key == f"{{{XLINK}}}href" and value.startswith("#"):
                element.set(key, f"#{prefix}--{value[1:]}")
            elif "url(#" in value:
                element.set(key, value.replace("url(#", f"url(#{prefix}--"))


def label(root, name, title, description, width, height):
    for key in ("width", "height"):
        root.attrib.pop(key, None)
    root.attrib.update({"viewBox": f"0 0 {width} {height}", "role": "img", "id": f"chart-{name}", "stroke-linejoin": "round",
                        "aria-labelledby": f"chart-{name}--title chart-{name}--desc"})
    for i, (tag, text) in enumerate((("title", title), ("desc", description))):
        element = ET.Element(f"{{{SVG}}}{tag}", {"id": f"chart-{name}--{tag}"})
        element.text = text
        root.insert(i, element)


def inline(root):
    return ET.tostring(root, encoding="unicode")


def standalone(root, width, height, footer):
    """The same picture as a file of its own: ground, both palettes, and how it was measured beneath."""
    root = ET.fromstring(ET.tostring(root))
    lines = wrap(footer, 68)
    full = height + 14 * len(lines) + 6
    root.attrib.update({"viewBox": f"0 0 {width} {full}", "width": str(width), "height": str(full)})
    style = ET.Element(f"{{{SVG}}}style")
    style.text = (f"svg{{{variables(0)}font-family:{FONT}}}{HALO}"
                  f"@media (prefers-color-scheme:dark){{svg{{{variables(1)}}}}}")
    root.insert(2, style)
    root.insert(3, ET.Element(f"{{{SVG}}}rect", {"width": str(width), "height": str(full), "style": "fill: var(--ground)"}))
    for i, line in enumerate(lines):
        place = {"x": "12", "y": str(height + 10 + 14 * i), "style": "fill: var(--muted); font-size: 10px"}
        element = ET.SubElement(root, f"{{{SVG}}}text", place)
        element.text = line
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def wrap(text, columns):
    lines = [""]
    for part in text.split(" · "):
        joined = f"{lines[-1]} · {part}" if lines[-1] else part
        lines = lines[:-1] + [joined] if len(joined) <= columns else lines + [part]
    return lines
