"""stability.json: what is read, refused and computed."""
import json
import math
import re
import unittest

import fixture
from report_case import WHY, MadeCase, matplotlib

METHODS = fixture.METHODS


@unittest.skipUnless(matplotlib, WHY)
class Stability(MadeCase):
    hard = fixture.stability()

    def remade(self, hard):
        """The report of other sweeps, without scenes."""
        data = {**fixture.results(), "scenes": []}
        self.make(data, hard=hard)
        return json.loads((self.folder / "report.json").read_text())

    def test_no_sweeps_no_section(self):
        self.make({**fixture.results(), "scenes": []})
        self.assertIsNone(json.loads((self.folder / "report.json").read_text())["stability"])
        self.assertNotIn("Stability", (self.folder / "report.html").read_text())
        self.assertFalse(list((self.folder / "charts").glob("stability-*")))

    def test_two_panels_a_sweep_as_files_too(self):
        charts = {p.name for p in (self.made / "charts").glob("stability-*")}
        self.assertEqual(charts, {f"stability-{s['id']}-{kind}.svg" for s in fixture.stability()["sweeps"] if s["points"]
                                  for kind in ("wrong", "resolved")})
        for name in charts:
            text = (self.made / "charts" / name).read_text()
            self.assertIn("vc-bench stability -o out", text)
            self.assertIn("depth 4", text)
        self.assertIn("No point was measured.", (self.made / "report.html").read_text())

    def test_rates_and_shares(self):
        hard, report = self.hard, self.report
        self.assertEqual([s["id"] for s in report["stability"]["sweeps"]], [s["id"] for s in hard["sweeps"]])
        unanswered = unasked = 0
        for sweep, made in zip(hard["sweeps"], report["stability"]["sweeps"]):
            self.assertEqual(len(made["rows"]), len(sweep["points"]))
            for point, row in zip(sweep["points"], made["rows"]):
                for m in METHODS:
                    r = point["results"].get(m)
                    unasked += r is None
                    unanswered += r is not None and r["resolved"] == 0
                    rate = r["wrong"] / r["resolved"] if r and r["resolved"] else None
                    share = r["resolved"] / point["rays"] if r else None
                    self.assertEqual((row[f"{m}_rate"], row[f"{m}_share"]), (rate, share))
        self.assertGreater(unanswered, 5)
        self.assertGreater(unasked, 5)

    def test_a_refusal_outweighs_zeros_beside_it(self):
        hard = fixture.stability()
        hard["sweeps"][1]["points"][4]["results"]["proven"] = {"wrong": 0, "resolved": 0}
        row = self.remade(hard)["stability"]["sweeps"][1]["rows"][4]
        self.assertIsNone(row["proven_share"])
        self.assertEqual(row["refused"], f"proven, hybrid, sampled, hierarchy: {fixture.REASON}")

    def test_the_worst_of_each_method(self):
        hard = self.hard
        worst = {w["method"]: w for w in self.report["stability"]["worst"]}
        self.assertEqual(list(worst), list(METHODS))
        for m in METHODS:
            all_ = [(p["results"][m]["wrong"], p["results"][m]["resolved"]) for s in hard["sweeps"] for p in s["points"] if m in p["results"]]
            rate = max(w / n for w, n in all_ if n)
            self.assertEqual(worst[m]["worst"]["rate"] if worst[m]["worst"] else 0, rate)
            self.assertEqual(worst[m]["most"]["wrong"] if worst[m]["most"] else 0, max(w for w, _ in all_))
            self.assertEqual((worst[m]["wrong"], worst[m]["resolved"]), tuple(map(sum, zip(*all_))))
            self.assertEqual(worst[m]["answered"], sum(n > 0 for _, n in all_))
            self.assertEqual(worst[m]["refused"], sum(m in p.get("refused", {}) for s in hard["sweeps"] for p in s["points"]))
        self.assertEqual(worst["sampled"]["worst"], {"where": "Special segments: from just off it", "rate": 1.0, "wrong": 1, "resolved": 1})
        self.assertEqual(worst["embree"]["worst"]["where"], "Very small & very large meshes: size of the mesh = 10⁻³⁰")
        self.assertIsNone(worst["proven"]["worst"])

    def test_lines_break_at_gaps(self):
        lines = lambda sweep, kind, m: sorted(int(i) for i in re.findall(
            rf'id="[\w-]*--line-{m}-(\d+)"', (self.made / "charts" / f"stability-{sweep}-{kind}.svg").read_text()))
        self.assertEqual(lines("scale", "wrong", "proven"), [0, 1, 2, 5, 6, 7, 8, 9])  # refused at 4, 11 and 12
        self.assertEqual(lines("scale", "wrong", "embree"), list(range(10)))
        self.assertEqual(lines("origin-distance", "wrong", "proven"), [0, 1])  # later it answers nothing
        self.assertEqual(lines("origin-distance", "resolved", "proven"), list(range(7)))

    def test_other_methods_have_their_place(self):
        hard = fixture.stability()
        hard["methods"] = ["proven", "other"]
        hard["sweeps"] = hard["sweeps"][:1]
        for point in hard["sweeps"][0]["points"]:
            point["results"] = {"other": {"wrong": 3, "resolved": 10}}
        report = self.remade(hard)
        self.assertEqual([w["answered"] for w in report["stability"]["worst"]], [0, 8])
        self.assertIn("it gave no answer.", (self.folder / "report.html").read_text())

    def test_refuses_what_it_should_not_be(self):
        sweeps = lambda d: d["sweeps"]
        result = lambda d: sweeps(d)[0]["points"][1]["results"]["hybrid"]
        for says, spoil in (
                ("not results of vc-bench stability", lambda d: d.update(tool="vc-bench")),
                ("methods: missing", lambda d: d.pop("methods")),
                ("sweeps: missing", lambda d: d.pop("sweeps")),
                ("methods[1]", lambda d: d["methods"].__setitem__(1, "proven")),
                ("methods[1]", lambda d: d["methods"].__setitem__(1, "../x")),
                ("sweeps[1].id: origin-distance is there twice", lambda d: sweeps(d)[1].update(id="origin-distance")),
                ("sweeps[0].scale", lambda d: sweeps(d)[0].update(scale="cubic")),
                ("sweeps[0].points[2].x", lambda d: sweeps(d)[0]["points"][2].update(x=0)),
                ("sweeps[2].points[0].x", lambda d: sweeps(d)[2]["points"][0].update(x="ten")),
                ("sweeps[3].points[0].x", lambda d: sweeps(d)[3]["points"][0].update(x=1)),
                ("sweeps[0].points[2].rays", lambda d: sweeps(d)[0]["points"][2].pop("rays")),
                ("results.hybrid", lambda d: result(d).update(wrong=1322)),
                ("results.hybrid", lambda d: result(d).update(resolved=2001)),
                ("results.hybrid", lambda d: result(d).pop("wrong")),
                ("results.hybrid.wrong", lambda d: result(d).update(wrong=-1)),
                ("refused.proven", lambda d: sweeps(d)[1]["points"][4]["refused"].update(proven=7)),
                ("NaN", lambda d: d.update(depth=math.nan))):
            with self.subTest(says):
                hard = fixture.stability()
                spoil(hard)
                done = self.make(hard=hard, code=3, says=says)
                self.assertIn("stability.json", done.stderr)
                self.assertNotIn("Traceback", done.stderr)
                self.assertFalse((self.folder / "report.html").exists())
