"""The page's numbers and points, held against the input."""
import math
import re

import page_browser
from report_case import PageCase, configurations

SUPERSCRIPT = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
UNIT = {"mib": 2 ** 20, "millions": 1e6, "percent": 0.01}


def number(text):
    """The value that a cell shows, and the half of its last digit."""
    text = text.replace("\u202f", "").replace("\u00a0", "").rstrip("×%s ")
    scale = 1.0
    if "×10" in text:
        text, power = text.split("×10")
        scale = 10.0 ** int(power.translate(SUPERSCRIPT))
    decimals = len(text.split(".")[1]) if "." in text else 0
    return float(text) * scale, 0.5000001 * 10.0 ** -decimals * scale


class Figures(PageCase):
    def test_tables_show_the_figures(self):
        shown = {t["id"]: t for t in self.browser.ask(page_browser.CELLS)}
        self.assertEqual(shown.keys(), {t["id"] for t in self.report["tables"]})
        compared = 0
        for table in self.report["tables"]:
            rows = [(s["scene"], r) for s in table["sections"] for r in s["rows"]]
            self.assertEqual([(s, r["id"]) for s, r in rows], [(r["scene"], r["row"]) for r in shown[table["id"]]["rows"]])
            for (_, row), seen in zip(rows, shown[table["id"]]["rows"]):
                self.assertEqual(seen["head"], row["label"])
                self.assertEqual(len(seen["cells"]), len(table["columns"]))
                for column, (exact, text) in zip(table["columns"], seen["cells"]):
                    compared += self.check_cell(row[column["key"]], column["format"], exact, text, table.get("absent", "not run"))
        self.assertGreater(compared, 2000)
        self.assert_measured(shown)

    def check_cell(self, value, kind, exact, text, absent):
        if value is None:
            self.assertEqual((exact, text), (None, absent))
        elif kind == "flag":
            self.assertEqual(text, "yes" if value else "no")
        elif kind == "text":
            self.assertEqual((exact, text), (value, value))
        else:
            self.assertEqual(float(exact), value)
            near, half = number(text)
            self.assertAlmostEqual(near * UNIT.get(kind, 1), value, delta=half * UNIT.get(kind, 1))
        return 1

    def assert_measured(self, shown):
        """The same cells against the input itself, past report.json."""
        for scene in (s for s in self.data["scenes"] if s["variants"]):
            rows = {(r["scene"], r["row"]): r["cells"] for r in shown["speedup"]["rows"]}
            paper = {r["row"]: r["cells"] for r in shown[f"paper-2-{scene['name']}"]["rows"]}
            for v in configurations(scene):
                cells = rows[scene["name"], v["id"]]
                self.assertEqual(cells[5][0], str(v["wrong"]))
                self.assertEqual(cells[6][0], repr(v["wrong_rate"]) if "wrong_rate" in v else None)
                self.assertEqual(cells[8][0], str(v["memory_bytes"]))
                self.assertEqual(paper[v["id"]][4][0], str(v["tests"]))
        killeroo = {r["row"]: r["cells"] for r in shown["paper-2-killeroo"]["rows"]}
        self.assertEqual([killeroo["d7-n256"][i][1] for i in (1, 5, 9, 11)], ["42.0", "173.6", "107", "2\u202f352"])

    def test_every_configuration_is_a_point_in_its_place(self):
        charts = {c["id"]: c for c in self.browser.ask(page_browser.CENTRES)}
        self.assertEqual(charts.keys(), {f"chart-{c['id']}" for c in self.report["charts"] + self.report["stability"]["charts"]})
        need = {"speedup": ("shadow_seconds", "wrong_rate"), "bake": ("bake_seconds", "wrong_rate"), "memory": ("memory_bytes", "segments")}
        for kind, keys in need.items():
            for scene in (s for s in self.data["scenes"] if s["variants"]):
                chart = charts[f"chart-{kind}-{scene['name']}"]
                run_ = {f"point-{kind}-{scene['name']}-{v['id']}": v for v in configurations(scene) if all(k in v for k in keys)}
                self.assertEqual({p["id"] for p in chart["points"]}, run_.keys())
                for p in chart["points"]:
                    self.assertEqual((float(p["data"]["x"]), float(p["data"]["y"])), self.expected(kind, scene, run_[p["id"]]))
                    self.assertEqual(p["data"]["method"], run_[p["id"]].get("method", "sampled"))
                self.check_axis(chart, "x", 0, chart["xScale"])
                self.check_axis(chart, "y", 1, chart["yScale"])
        for scene in (s for s in self.data["scenes"] if s["kinds"]):
            chart = charts[f"chart-kinds-{scene['name']}"]
            medians = {f"point-kinds-{scene['name']}-{e['variant']}-{k['kind']}": e["ns"]["median"] for k in scene["kinds"] for e in k["vcd"]}
            self.assertEqual({p["id"]: float(p["data"]["x"]) for p in chart["points"]}, medians)
            self.check_axis(chart, "x", 0, "log")

    @staticmethod
    def expected(kind, scene, v):
        if kind == "speedup":
            return v["wrong_rate"], scene["variants"][0]["shadow_seconds"]["median"] / v["shadow_seconds"]["median"]
        if kind == "bake":
            return v["bake_seconds"], v["wrong_rate"]
        return v["memory_bytes"], v["resolved_segments"] / v["segments"]

    def check_axis(self, chart, axis, index, scale):
        """A line through (value, pixel) of the points must meet each point, and each tick's label, which must say its value."""
        value = (lambda v: v) if scale == "linear" else math.log10
        pairs = [(float(p["data"][axis]), p["at"][index]) for p in chart["points"]]
        zeros = [(p["data"]["method"], p["at"][index]) for p, (v, _) in zip(chart["points"], pairs) if v == 0]
        pairs = [(value(v), pixel) for v, pixel in pairs if v != 0]
        n, mx, my = len(pairs), sum(a for a, _ in pairs) / len(pairs), sum(b for _, b in pairs) / len(pairs)
        slope = sum((a - mx) * (b - my) for a, b in pairs) / sum((a - mx) ** 2 for a, _ in pairs)
        at = lambda v: my + slope * (value(v) - mx)
        self.assertGreater(n, 2)
        self.assertGreater(slope * (1 if axis == "x" else -1), 0, chart["id"])
        for v, pixel in pairs:
            self.assertAlmostEqual(my + slope * (v - mx), pixel, delta=0.7, msg=f"{chart['id']} {axis} {v}")
        ticks = [t for t in chart["ticks"] if t["data"]["axis"] == axis and float(t["data"]["v"]) > 0]
        self.assertGreaterEqual(len(ticks), 2)
        for tick in ticks:
            v = float(tick["data"]["v"])
            self.assertAlmostEqual(at(v), tick["at"][index], delta=2.5, msg=f"{chart['id']} {axis} {tick['text']}")
            self.assertTrue(self.says(tick["text"], v, chart["id"]), (tick["text"], v))
        self.check_zero(chart, axis, index, scale, zeros, [t["at"][index] for t in ticks])

    @staticmethod
    def says(text, value, chart):
        power = re.fullmatch(r"10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) %", text)
        shown = 10.0 ** int(power[1].translate(SUPERSCRIPT)) if power else number(text)[0]
        unit = 0.01 if "%" in text else 2 ** 20 if chart.startswith("chart-memory") else 1
        return abs(shown * unit / value - 1) < 1e-9

    def check_zero(self, chart, axis, index, scale, zeros, ticks):
        """Zero has a place of its own beyond every value, under its label."""
        label = [t["at"][index] for t in chart["ticks"] if t["text"] == "0 seen" and t["data"]["axis"] == axis]
        self.assertEqual(len(label), 1 if scale == "rate" else 0)
        present = [m for m in ("proven", "hybrid", "sampled") if any(p["data"].get("method") == m for p in chart["points"])]
        for method, pixel in zeros:  # a lane a method, from the axis on
            lane = (present.index(method) + 0.5) / len(present) - 0.5
            scale_ = chart["box"][2] / 380
            self.assertAlmostEqual(pixel, label[0] + lane * 41 * scale_ * (1 if axis == "x" else -1), delta=2)
            self.assertTrue(pixel < min(ticks) - 6 if axis == "x" else pixel > max(ticks) + 6)
        self.assertEqual(len(zeros), sum(float(p["data"][axis]) == 0 for p in chart["points"]) if scale == "rate" else 0)
        if scale == "rate":
            self.assertEqual(len(zeros), {"killeroo": 6, "hairball": 3}.get(chart["id"].split("-")[2], 0) if "speedup" in chart["id"] else len(zeros))

    def test_no_wrong_ray_seen_shows_the_bound(self):
        tips = {p["id"]: p["tip"] for c in self.browser.ask(page_browser.CENTRES) for p in c["points"]}
        self.assertIn("no wrong ray seen (95\u00a0% bound 7.50×10⁻⁵\u00a0%)", tips["point-speedup-killeroo-d5-n256"])
