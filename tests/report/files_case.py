"""The files beside the page, and every figure that is derived."""
import csv
import json
import unittest
import xml.etree.ElementTree as ET

import fixture
from report_case import TOOL, WHY, MadeCase, files, matplotlib


@unittest.skipUnless(matplotlib, WHY)
class Files(MadeCase):
    def test_same_input_same_bytes(self):
        self.make()
        first = files(self.folder)
        self.assertEqual(files(self.made), first)
        self.make()  # over what is there
        self.assertEqual(files(self.folder), first)
        self.assertFalse([n for n in first if ".tmp" in n])

    def test_charts_stand_alone(self):
        data = fixture.results()
        charts = {p.name for p in (self.made / "charts").iterdir()}
        measured = [s["name"] for s in data["scenes"] if s["variants"]]
        self.assertEqual(charts, {f"{c}-{s}.svg" for c in ("speedup", "bake", "memory") for s in measured} |
                         {f"kinds-{s['name']}.svg" for s in data["scenes"] if s["kinds"]})
        for path in (self.made / "charts").iterdir():
            text = path.read_text()
            ET.fromstring(text)
            self.assertIn("prefers-color-scheme:dark", text)
            self.assertIn("Made-up Processor 9", text)
            self.assertNotRegex(text, r"#fe[0-9a-f]{2}01|<metadata|20\d\d-\d\d-\d\d")

    def test_csv_has_a_row_for_each_scene_and_variant(self):
        data, report = fixture.results(), self.report
        with open(self.made / "report.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([(r["scene"], r["id"]) for r in rows], [(s["name"], v["id"]) for s in data["scenes"] for v in s["variants"]])
        flat = [v for s in report["scenes"] for v in s["variants"]]
        for row, figures in zip(rows, flat):
            for key, value in figures.items():
                self.assertEqual(row[key], "" if value is None else str(value), key)
        self.assertEqual(float(rows[1]["timed_piercing_ns"]), data["scenes"][0]["kinds"][1]["vcd"][0]["ns"]["median"])
        self.assertEqual(int(rows[1]["image_own_wrong"]), data["scenes"][0]["variants"][1]["kinds"][2]["wrong"])

    def test_derived_figures(self):
        for scene, made in zip(fixture.results()["scenes"], self.report["scenes"]):
            bvh = scene["variants"][0] if scene["variants"] else None
            for v, row in zip(scene["variants"], made["variants"]):
                if "shadow_seconds" in v:
                    a, b = bvh["shadow_seconds"], v["shadow_seconds"]
                    self.assertAlmostEqual(row["speedup"], a["median"] / b["median"])
                    self.assertAlmostEqual(row["speedup_low"], a["minimum"] / b["maximum"])
                    self.assertAlmostEqual(row["speedup_high"], a["maximum"] / b["minimum"])
                    self.assertAlmostEqual(row["shadow_ratio"], b["median"] / a["median"])
                else:
                    self.assertIsNone(row["speedup"])
                self.assertEqual(row["wrong_rate"], v.get("wrong_rate"))
                if "segments" in v:
                    self.assertAlmostEqual(row["resolved_share"], v["resolved_segments"] / v["segments"])
            by = {(r["kind"], r["id"]): r for r in made["kinds"]}
            for kind in scene["kinds"]:
                best = next(e["ns"]["median"] for e in kind["embree"] if e["name"] == kind["best_embree"])
                for e in kind["vcd"]:
                    row = by[kind["kind"], e["variant"]]
                    self.assertAlmostEqual(row["ratio"], best / e["ns"]["median"])
                    self.assertAlmostEqual(row["single_ratio"], kind["embree"][0]["ns"]["median"] / e["ns"]["median"])
                    self.assertAlmostEqual(row["wrong_rate"], e["wrong"] / e["segments"])
                    self.assertAlmostEqual(row["wrong_resolved_rate"], e["wrong_resolved"] / e["resolved"])
                    self.assertGreater(row["wrong_resolved_bound_95"], row["wrong_resolved_rate"])

    def test_tracing_ray_by_ray_has_its_line(self):
        charts = {c["scene"]: c for c in self.report["charts"] if c["chart"] == "speedup"}
        for scene in fixture.results()["scenes"]:
            shadow = {v["id"]: v.get("shadow_seconds") for v in scene["variants"]}
            if shadow.get("bvh-single"):
                self.assertAlmostEqual(charts[scene["name"]]["single"], shadow["bvh"]["median"] / shadow["bvh-single"]["median"])
                self.assertIn("single-speedup-" + scene["name"], (self.made / "charts" / f"speedup-{scene['name']}.svg").read_text())

    def test_the_bound_is_poissons(self):
        from figures import upper_bound_95
        self.assertAlmostEqual(upper_bound_95(0, 1_000_000), 2.9957e-6, 9)
        self.assertAlmostEqual(upper_bound_95(10, 1000), 16.962e-3, 5)
        self.assertAlmostEqual(upper_bound_95(1001, 1000 * 1001) / upper_bound_95(1000, 1000 * 1000), 1, 4)

    def test_the_frontier_holds_no_beaten_point(self):
        for chart in (c for c in self.report["charts"] if c["chart"] == "speedup"):
            points = {p["variant"]: (p["x"], p["y"]) for p in chart["points"]}
            beaten = {a for a, (x, y) in points.items()
                      if y <= 1 or any((u < x and v >= y) or (u <= x and v > y) for u, v in points.values())}
            self.assertEqual(set(chart["frontier"]), points.keys() - beaten)
            self.assertTrue(chart["frontier"])

    def test_hierarchies_and_a_judged_embree_are_points_beside_the_trees(self):
        data = fixture.results()
        killeroo = data["scenes"][0]
        killeroo["judge"] = "exact arithmetic"
        bvh, trees = killeroo["variants"][0], {v["id"]: v for v in killeroo["variants"]}
        bvh.update(wrong=40, wrong_rate=1e-5, wrong_bound_95=1.3e-5, segments=4_000_000)
        for name, behind, gain, rate in (("hierarchy", None, 3.0, 0), ("d5-n81-hierarchy", "d5-n81", 4.0, trees["d5-n81"]["wrong_rate"])):
            times = {k: {m: t / gain for m, t in bvh[k].items()} for k in ("render_seconds", "shadow_seconds")}
            killeroo["variants"].append({"id": name, "label": name, **({"behind": behind} if behind else {}), **times, "segments": 4_000_000,
                                         "wrong": round(rate * 4e6), "wrong_rate": rate, "wrong_bound_95": rate + 1e-6})
        self.make(data)
        report = json.loads((self.folder / "report.json").read_text())
        charts = {c["id"]: {p["variant"]: p for p in c["points"]} for c in report["charts"]}
        points = charts["speedup-killeroo"]
        self.assertEqual((points["bvh"]["x"], points["bvh"]["y"], points["bvh"]["method"]), (1e-5, 1, "embree"))
        self.assertEqual((points["hierarchy"]["x"], points["hierarchy"]["method"], points["hierarchy"]["depth"]), (0, "hierarchy", None))
        behind = points["d5-n81-hierarchy"]
        self.assertEqual((behind["behind"], behind["depth"], behind["samples"], behind["area"]), ("d5-n81", 5, 81, trees["d5-n81"]["memory_bytes"]))
        for other in ("bake-killeroo", "memory-killeroo"):
            self.assertFalse({"bvh", "hierarchy", "d5-n81-hierarchy"} & charts[other].keys())
        self.assertFalse({"bvh", "hierarchy"} & charts["speedup-sierpinski"].keys())
        frontier = next(c["frontier"] for c in report["charts"] if c["id"] == "speedup-killeroo")
        self.assertIn("hierarchy", frontier)
        self.assertNotIn("bvh", frontier)  # slower, and more wrong rays
        svg = (self.folder / "charts" / "speedup-killeroo.svg").read_text()
        for text in (">H<", ">E<", ">81+H<"):
            self.assertIn(text, svg)
        judges = next(t for t in report["tables"] if t["id"] == "scenes")["sections"][0]["rows"]
        self.assertEqual([r["judge"] for r in judges[:2]], ["exact arithmetic", "Embree"])

    def test_paper_figures(self):
        """Sums over the columns of Table 2, and Table 1, typed from the paper a second time."""
        paper = json.loads((TOOL / "paper.json").read_text())
        sums = {"render_seconds": (424.4, 1038.8, 854.2, 3218.2), "tests_millions": (1920.1, 10236.4, 14695.33, 32193.29),
                "memory_mib": (342.6, 422.3, 946.4, 2566.3), "build_seconds": (3892.1, 3244.0, 19821.1, 44907.6),
                "error_percent": (2.4669, 4.218, 4.044, 4.023)}
        for key, columns in sums.items():
            for scene, expected in zip(("killeroo", "sierpinski", "hairball", "forest"), columns):
                self.assertAlmostEqual(sum(v.get(key, 0) for v in paper["table2"][scene].values()), expected, 6)
        self.assertEqual([(v["uncompressed_mib"], v["compressed_mib"]) for v in paper["table1"].values()],
                         [(1036, 107), (1786, 146), (4539, 284), (11165, 794)])

    def test_trends_tell_what_holds(self):
        import figures
        import trends
        scenes = [figures.scene_figures(s) for s in fixture.results()["scenes"]]
        paper = json.loads((TOOL / "paper.json").read_text())
        made = {t["id"]: t for t in trends.all_trends(scenes, paper, {"tests-fall-with-depth": "Because.", "memory-grows-with-depth": "Never shown."})}
        self.assertEqual(len(made), 8)
        tests = {s["scene"]: s for s in made["tests-fall-with-depth"]["scenes"]}
        self.assertEqual(tests["killeroo"]["verdict"], "holds, as in the paper")
        self.assertEqual(tests["sierpinski"]["verdict"], "does not hold here; it does in the paper")
        self.assertEqual([(s["what"], s["here"][1], s["paper"]) for s in tests["sierpinski"]["deviations"]],
                         [("samples 81, depth 6 → 7", 10 ** 9, [1015e6, 959e6])])
        self.assertEqual(tests["lost"]["verdict"], "not run")
        self.assertEqual(made["tests-fall-with-depth"]["remark"], "Because.")
        self.assertIsNone(made["memory-grows-with-depth"]["remark"])
        render = {s["scene"]: s for s in made["render-falls-with-depth"]["scenes"]}
        self.assertEqual(render["sierpinski"]["held_paper"], 5)  # 100.4 s, then 100.7 s
        gain = made["gain-larger-on-complex"]["scenes"]
        self.assertEqual([(s["scene"], s["steps"], s["held_here"]) for s in gain], [("hairball", 18, 18), ("forest", 8, 8)])
