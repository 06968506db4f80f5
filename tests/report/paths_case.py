"""The path tracer's charts and tables, from figures that a scene's paths have."""
import unittest

import chart_data
import figures
import tables

NAMES = {"rtcOccluded1": 50, "look-ups, then rtcOccluded1": 55, "hierarchy": 40, "d5-proven-hierarchy": 25}


def times(scale, best):
    """As vc-bench writes them: Embree's one way, and the others."""
    rows = [{"name": n, "median_ns": scale * t, "minimum_ns": scale * t * 0.9, "maximum_ns": scale * t * 1.1, "speed_up": 50 / t} for n, t in NAMES.items()]
    return {"best_embree": best, "embree": rows[:1], "vcd": rows[1:]}


def scene():
    return {"name": "tree", "title": "tree", "kinds": [], "triangles": 100, "variants": [
        {"id": "bvh"}, {"id": "d5-proven", "depth": 5, "method": "proven", "memory_bytes": 1000, "hierarchy_bytes": 3500, "horizon_bytes": 0},
        {"id": "hierarchy", "label": "hierarchy alone"}, {"id": "d5-proven-hierarchy", "label": "both", "behind": "d5-proven"}],
        "paths": {"segments": 5000, "judged": 1000, "wrong_embree": 3, "wrong": {"hierarchy": 0, "d5-proven-hierarchy": 2},
                  "single_calls": times(1, "rtcOccluded1"), "wavefronts": times(0.5, "rtcOccluded1")}}


class Paths(unittest.TestCase):
    def setUp(self):
        self.scene = figures.scene_figures(scene())

    def test_each_use_has_a_chart_of_what_asks_no_embree(self):
        charts = {c["chart"]: c for c in chart_data.all_charts([self.scene])}
        for use in figures.USES:
            points = {p["variant"]: p for p in charts[use]["points"]}
            self.assertEqual(set(points), {"bvh", "hierarchy", "d5-proven-hierarchy"})  # Embree behind look-ups is charted elsewhere
            self.assertEqual((points["bvh"]["y"], points["hierarchy"]["y"], points["d5-proven-hierarchy"]["y"]), (1, 1.25, 2))
            self.assertEqual([points[v]["x"] for v in ("bvh", "hierarchy", "d5-proven-hierarchy")], [0.003, 0, 0.002])
            self.assertEqual(points["d5-proven-hierarchy"]["area"], 1000)
            self.assertAlmostEqual(points["hierarchy"]["y_low"], 50 * 0.9 / (40 * 1.1))
            self.assertEqual(charts[use]["frontier"], ["hierarchy", "d5-proven-hierarchy"])
        self.assertNotIn("speedup", charts)  # no picture was timed

    def test_each_use_has_a_table_with_its_own_times(self):
        shown = {t["id"]: t["sections"][0]["rows"] for t in tables.all_tables([self.scene])}
        for use, scale in zip(figures.USES, (1, 0.5)):
            rows = {r["id"]: r for r in shown[use]}
            self.assertEqual({i: r["ns"] for i, r in rows.items()}, {"bvh": 50 * scale, "hierarchy": 40 * scale, "d5-proven-hierarchy": 25 * scale})
            self.assertEqual((rows["hierarchy"]["judged"], rows["d5-proven-hierarchy"]["wrong"], rows["bvh"]["wrong"]), (1000, 2, 3))
        tree, = shown["memory"]
        self.assertEqual((tree["hierarchy_bytes_a_triangle"], tree["horizon_bytes_a_triangle"]), (35, 0))

    def test_a_scene_without_paths_has_neither(self):
        bare = scene()
        del bare["paths"]
        found = figures.scene_figures(bare)
        self.assertTrue(all(found[use] == [] for use in figures.USES))
        self.assertFalse(any(c["chart"] in figures.USES for c in chart_data.all_charts([found])))


if __name__ == "__main__":
    unittest.main()
