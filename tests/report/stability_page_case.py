"""The section on stability in a browser: each mark in its place, and all words legible."""
import math

import fixture
import page_browser
from report_case import PageCase

METHODS = fixture.METHODS


class StabilityPage(PageCase):
    def charts(self):
        return {c["id"]: c for c in self.browser.ask(page_browser.CENTRES) if c["id"].startswith("chart-stability-")}

    def expected(self, sweep, kind):
        """Point's id → (along, value), of all that were asked and, for a rate, answered."""
        made = {}
        for i, point in enumerate(sweep["points"]):
            for m, r in point["results"].items():
                if kind == "resolved" or r["resolved"]:
                    value = r["wrong"] / r["resolved"] if kind == "wrong" else r["resolved"] / point["rays"]
                    made[f"point-stability-{sweep['id']}-{kind}-{i}-{m}"] = (i if sweep["scale"] == "category" else point["x"], value)
        return made

    def test_every_point_is_in_its_place(self):
        charts = self.charts()
        for sweep in (s for s in self.hard["sweeps"] if s["points"]):
            names = sweep["scale"] == "category"
            for kind in ("wrong", "resolved"):
                chart, expected = charts.pop(f"chart-stability-{sweep['id']}-{kind}"), self.expected(sweep, kind)
                along, value = ("y", "x") if names else ("x", "y")
                self.assertEqual({p["id"]: (float(p["data"][along]), float(p["data"][value])) for p in chart["points"]}, expected)
                self.on_one_line(chart, value, math.log10 if kind == "wrong" else float)
                self.on_one_line(chart, along, math.log10 if sweep["scale"] == "log" else float, 30 if names else 1)
                if kind == "wrong":
                    self.zeros(chart, value)
        self.assertEqual(charts, {})

    def on_one_line(self, chart, axis, value, slack=1.0):
        """Ticks tell the scale; each point that is not a rate's zero must lie where they say."""
        index, rate = "xy".index(axis), chart[axis + "Scale"] == "rate"
        ticks = sorted((value(float(t["data"]["v"])), t["at"][index]) for t in chart["ticks"]
                       if t["data"]["axis"] == axis and (float(t["data"]["v"]) > 0 or value is float))
        self.assertGreaterEqual(len(ticks), 2, (chart["id"], axis))
        (v0, p0), (v1, p1) = ticks[0], ticks[-1]
        at = lambda v: p0 + (v - v0) / (v1 - v0) * (p1 - p0)
        for p in chart["points"]:
            v = float(p["data"][axis])
            if not (rate and v == 0):
                self.assertAlmostEqual(p["at"][index], at(value(v)), delta=slack + 2.5, msg=p["id"])

    def zeros(self, chart, axis):
        """Under the label, beyond every other value, and never one upon the other."""
        index, ticks = "xy".index(axis), [t for t in chart["ticks"] if t["data"]["axis"] == axis]
        label, = [t["at"][index] for t in ticks if t["text"] == "0 of N"]
        scale = chart["box"][2] / 380
        side = 1 if axis == "x" else -1
        end = min(side * t["at"][index] for t in ticks if t["text"] != "0 of N")
        spots = [tuple(p["at"]) for p in chart["points"] if float(p["data"][axis]) == 0]
        for spot in spots:
            self.assertLess(abs(spot[index] - label), 19 * scale)
            self.assertLess(side * spot[index], end)
        for i, a in enumerate(spots):
            for b in spots[:i]:
                self.assertGreater(math.dist(a, b), 6.5 * scale, "zeros hide each other")
        self.assertGreater(len(spots), 3, chart["id"])

    def test_marks_say_none_of_how_many(self):
        tips = {p["id"]: p["tip"] for c in self.charts().values() for p in c["points"]}
        self.assertEqual(tips["point-stability-scale-wrong-0-proven"],
                         "Very small & very large meshes, 10⁻³⁰, proven: none of 1\u202f740 wrong (95\u00a0% bound 0.172\u00a0%)")
        self.assertEqual(tips["point-stability-segments-wrong-0-sampled"], "Special segments, along an axis, sampled: 132 of 1\u202f615 wrong, 8.17\u00a0%")
        self.assertEqual(tips["point-stability-scale-resolved-0-embree"],
                         "Very small & very large meshes, 10⁻³⁰, Embree: 2\u202f000 of 2\u202f000 answered, 100\u00a0%")
        captions = self.browser.ask("return [...document.querySelectorAll('#sweep-tilt figcaption')].map(e => e.textContent)")
        self.assertEqual(captions, ["Worst: sampled, 10: 40 of 18\u202f500 wrong, 0.216\u00a0%. N: the rays that a method answered, of 20\u202f000 asked.",
                                    "Fewest: proven, -10: 18\u202f000 of 20\u202f000 answered, 90.0\u00a0%."])

    def test_shares_reach_from_none_to_all(self):
        for name, chart in self.charts().items():
            axis = "x" if chart["yScale"] == "category" else "y"
            shown = [float(t["data"]["v"]) for t in chart["ticks"] if t["data"]["axis"] == axis]
            if name.endswith("-resolved"):
                self.assertEqual((min(shown), max(shown)), (0, 1), name)

    def test_names_stand_beside_their_bands(self):
        chart = self.charts()["chart-stability-segments-wrong"]
        texts = [t["text"] for t in chart["ticks"] if t["data"]["axis"] == "y"]
        self.assertEqual(texts, ["along an axis", "in a face of the", "box", "in a triangle's", "plane", "from just off it", "through both ends", "of an edge,…"])

    def test_words_neither_overlap_nor_leave_the_picture(self):
        trouble = self.browser.ask("""const out = [];
          for (const svg of document.querySelectorAll('svg[id^=chart-stability-]')) {
            const frame = svg.getBoundingClientRect(), texts = [...svg.querySelectorAll('text')].map(t => [t.textContent, t.getBoundingClientRect()]);
            texts.forEach(([text, a], i) => {
              if (a.left < frame.left - 1 || a.right > frame.right + 1 || a.top < frame.top || a.bottom > frame.bottom) out.push([svg.id, text, 'outside']);
              for (const [other, b] of texts.slice(0, i))
                if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 5) out.push([svg.id, text, other]);
            });
          } return out;""")
        self.assertEqual(trouble, [])

    def test_the_summary(self):
        items = self.browser.ask("return [...document.querySelectorAll('#stability .methods li')].map(e => [e.dataset.method, e.querySelector('.big').textContent, e.querySelector('small').textContent])")
        self.assertEqual([i[0] for i in items], list(METHODS))
        self.assertEqual([i[1] for i in items], ["none", "0.753\u00a0%", "100\u00a0%", "none", "74.2\u00a0%", "74.2\u00a0%"])
        self.assertIn("at worst: Special segments: along an axis, 11 of 1\u202f460 answers", items[1][2])
        self.assertIn("at worst: Special segments: from just off it, 1 of 1 answers. The most: Special segments: along an axis, 132 of 1\u202f615.", items[2][2])
        self.assertIn("Refused at 4.", items[0][2])
        self.assertNotIn("Refused", items[4][2])

    def test_reasons_of_refusals(self):
        notes = self.browser.ask("return [...document.querySelectorAll('#stability .refused')].map(e => e.textContent)")
        self.assertEqual(notes, [
            '10⁻¹⁰, 10²⁵, 10³⁰: refused (proven, hybrid, sampled, hierarchy): mesh 0 "sphere": its box is <too large> & no float',
            "through both ends of an edge, <then> some: refused (proven, hybrid, hierarchy): too thin",
            "through both ends of an edge, <then> some: refused (sampled): its own reason"])
        words = self.browser.ask("return [...document.querySelectorAll('#chart-stability-scale-wrong text')].filter(t => t.textContent.trim() === 'refused').length")
        self.assertEqual(words, 2)
