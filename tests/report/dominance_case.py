"""Proven and hybrid trees: a series of their own, and what is said of them against the sampled ones."""
import re
import unittest
import xml.etree.ElementTree as ET

import fixture
from report_case import WHY, MadeCase, matplotlib, sampled

XLINK = "{http://www.w3.org/1999/xlink}href"
PROVED = ("proven", "hybrid")


def row(id_, method, speedup, wrong, spread=0.0):
    return {"id": id_, "label": id_, "method": method, "depth": 5, "samples": 16 if method == "sampled" else None, "speedup": speedup,
            "speedup_low": speedup - spread, "speedup_high": speedup + spread, "wrong": wrong, "wrong_rate": wrong / 1000}


@unittest.skipUnless(matplotlib, WHY)
class Dominance(MadeCase):
    def judge(self, *rows):
        import dominance
        return dominance.of_scene({"name": "s", "title": "S", "variants": list(rows)})

    def test_every_sampled_tree_is_judged(self):
        """Against the input, by hand."""
        report = self.report
        made = {d["scene"]: d for d in report["dominance"]}
        found = {}
        for scene in fixture.results()["scenes"]:
            timed = [v for v in scene["variants"] if "shadow_seconds" in v and "wrong" in v and "wrong_rate" in v]
            fast = lambda v: v["shadow_seconds"]["median"]
            beaten = lambda s, of: any(fast(p) <= fast(s) and p["wrong"] <= s["wrong"] for p in of)
            of = {m: [v for v in timed if v.get("method") == m] for m in PROVED}
            rows, d = [v for v in timed if "samples" in v], made[scene["name"]]
            self.assertEqual(d["sampled"], len(rows))
            self.assertEqual(d["dominated_by"], {m: sum(beaten(s, of[m]) for s in rows) for m in PROVED if of[m]})
            proved = of["proven"] + of["hybrid"]
            left = [s["id"] for s in rows if not beaten(s, proved)] if proved else []
            self.assertEqual([e["id"] for e in d["exceptions"]], left)
            found[scene["name"]] = (d["dominated"], len(left))
        self.assertEqual(found, {"killeroo": (9, 0), "sierpinski": (0, 9), "hairball": (6, 3), "forest": (None, 0), "lost": (None, 0)})

    def test_equal_is_enough(self):
        self.assertEqual(self.judge(row("s", "sampled", 1.2, 5), row("p", "proven", 1.2, 5))["exceptions"], [])
        self.assertEqual(len(self.judge(row("s", "sampled", 1.2, 5), row("p", "proven", 1.19, 5))["exceptions"]), 1)
        self.assertEqual(len(self.judge(row("s", "sampled", 1.2, 5), row("p", "proven", 1.2, 6))["exceptions"]), 1)

    def test_trees_for_the_scene_itself_take_no_part(self):
        for_scene = {**row("p", "proven", 2, 0), "demand": True}
        judged = self.judge(row("s", "sampled", 1.2, 5), for_scene, row("h", "hybrid", 1.1, 5))
        self.assertEqual((judged["proved"], judged["dominated"]), (1, 0))
        import figures
        self.assertEqual(figures.label_of({"id": "demand-proven", "depth": 8, "method": "proven", "demand": True}), "for the scene, proven, down to depth 8")

    def test_what_the_closest_lacks(self):
        s = row("s", "sampled", 1.5, 5, 0.1)
        lacks = lambda *proved: [(e["closest"], e["closest_speedup"], e["closest_wrong"], e["lacks"]) for e in self.judge(s, *proved)["exceptions"]]
        self.assertEqual(lacks(row("p", "proven", 1.1, 0), row("h", "hybrid", 1.3, 5)), [("h", 1.3, 5, "slower")])
        self.assertEqual(lacks(row("p", "proven", 1.45, 0)), [("p", 1.45, 0, "slower, within the spread of the repetitions")])
        self.assertEqual(lacks(row("h", "hybrid", 1.9, 9), row("g", "hybrid", 1.6, 7)), [("g", 1.6, 7, "more wrong rays")])

    def test_the_page_says_it(self):
        text = (self.made / "report.html").read_text()
        said = dict(re.findall(r'<li data-scene="(\w+)">(.*?)</li>', text))
        plain = {scene: re.sub("<.*?>", "", html) for scene, html in said.items()}
        self.assertEqual(plain["killeroo"], "Killeroo: proven and hybrid trees dominate every sampled tree: of 9, 6 by a proven one, 6 by a hybrid one.")
        self.assertEqual(plain["sierpinski"], "Sierpinski: proven and hybrid trees dominate none of 9 sampled trees.")
        self.assertIn("dominate 6 of 9 sampled trees (0 by a proven one, 6 by a hybrid one), and not: "
                      "depth 5, 256 samples; depth 6, 256 samples; depth 7, 256 samples.", plain["hairball"])
        self.assertIn("no proven or hybrid tree was timed and counted", plain["forest"])
        self.assertEqual(len(re.findall("<tr data-row", re.search('<table id="table-dominance".*?</table>', text, re.S)[0])), 12)

    def test_sampled_alone_needs_no_table(self):
        data = fixture.results()
        for scene in data["scenes"]:
            scene["variants"] = [v for v in scene["variants"] if v.get("method") not in PROVED]
            scene["kinds"] = []
        self.make(data)
        text = (self.folder / "report.html").read_text()
        self.assertNotIn('id="table-dominance"', text)
        self.assertNotIn("key-proven", text)
        self.assertEqual(text.count("no proven or hybrid tree was timed and counted"), 4)

    def shapes(self, path):
        """Point → the kind of outline that its marker has."""
        root = ET.parse(path).getroot()
        outlines = {e.get("id"): re.sub(r"[-\d.e\s]+", "", e.get("d")) for e in root.iter() if e.tag.endswith("}path") and e.get("id")}
        points = [e for e in root.iter() if e.get("class") == "point"]
        return {(p.get("data-variant"), p.get("data-method")): outlines[next(u for u in p.iter() if u.tag.endswith("}use")).get(XLINK)[1:]]
                for p in points}, {e.get("id").split("--")[-1] for e in root.iter() if "key-" in e.get("id", "")}

    def test_methods_have_shapes_of_their_own_and_a_legend(self):
        for chart in ("speedup", "bake", "memory"):
            shapes, keys = self.shapes(self.made / "charts" / f"{chart}-killeroo.svg")
            by_method = {m: {s for (_, method), s in shapes.items() if method == m} for m in (*PROVED, "sampled")}
            self.assertEqual([len(by_method[m]) for m in PROVED], [1, 1])
            self.assertEqual(len(set.union(*by_method.values())), 2 + len(by_method["sampled"]))
            self.assertEqual(len(shapes), 15)
            self.assertEqual(keys, {"key-proven", "key-hybrid"})
        self.assertEqual(self.shapes(self.made / "charts" / "speedup-sierpinski.svg")[1], {"key-hybrid"})

    def test_tables_list_them(self):
        report = self.report
        for table in (t for t in report["tables"] if t["id"] in ("speedup", "bake", "memory", "paper-2-killeroo")):
            rows = next(s["rows"] for s in table["sections"] if s["scene"] == "killeroo")
            labels = [r["label"] for r in rows if r["id"] in ("d5-proven", "d6-proven", "d7-proven", "d5-hybrid", "d6-hybrid", "d7-hybrid")]
            self.assertEqual(labels, [f"depth {d}, {m}" for m in PROVED for d in (5, 6, 7)], table["id"])
        self.assertIn("d5-proven,\"depth 5, proven\",proven,5,,", (self.made / "report.csv").read_text())

    def test_the_papers_statements_stay_with_its_method(self):
        report = self.report
        steps = {t["id"]: t["scenes"][0]["steps"] for t in report["trends"]}
        self.assertEqual(steps["memory-grows-with-depth"], 6)
        self.assertEqual(len(sampled(fixture.results()["scenes"][0])), 9)
