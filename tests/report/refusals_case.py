"""What the generator refuses, and how."""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import fixture
from report_case import TOOL, WHY, Case, files, matplotlib, run


@unittest.skipUnless(matplotlib, WHY)
class Refusals(Case):
    """An error names file and reason, and an earlier report stays as it is."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.earlier = pathlib.Path(holder.name) / "earlier"
        fixture.write(cls.earlier)
        assert run(cls.earlier).returncode == 0

    def refuses(self, spoil, code, *says):
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(self.earlier, self.folder)
        before = files(self.folder)
        spoil(self.folder)
        done = run(self.folder)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        for text in says:
            self.assertIn(text, done.stderr)
        after = files(self.folder)
        for name in before:
            if name.startswith(("report.", "charts/")) and name in after:
                self.assertEqual(after[name], before[name], name)
        self.assertIn("report.json", after)
        self.assertFalse([n for n in after if ".tmp" in n])

    def edit(self, change):
        def spoil(folder):
            data = fixture.results()
            change(data)
            (folder / "results.json").write_text(json.dumps(data))
        return spoil

    def test_missing_results(self):
        self.refuses(lambda f: (f / "results.json").unlink(), 2, "results.json", "No such file")

    def test_malformed_json(self):
        self.refuses(lambda f: (f / "results.json").write_text('{"tool": "vc-bench", '), 3, "results.json", "line 1")

    def test_not_a_number(self):
        self.refuses(self.edit(lambda d: d["scenes"][0]["variants"][1].update(tests=math.nan)), 3, "NaN")

    def test_wrong_type_is_named_by_its_place(self):
        self.refuses(self.edit(lambda d: d["scenes"][1]["variants"][2].update(wrong_rate="many")), 3, "scenes[1].variants[2].wrong_rate")
        self.refuses(self.edit(lambda d: d["scenes"][0]["variants"][2]["shadow_seconds"].pop("median")), 3, "shadow_seconds")
        self.refuses(self.edit(lambda d: d["scenes"][0].update(name="../x")), 3, "scenes[0].name")
        self.refuses(self.edit(lambda d: d["scenes"][1].update(name="killeroo")), 3, "twice")

    def test_another_format(self):
        self.refuses(self.edit(lambda d: d.update(format=2)), 3, "format")
        self.refuses(self.edit(lambda d: d.update(tool="other")), 3, "not results of vc-bench")

    def test_missing_image(self):
        self.refuses(lambda f: (f / "images/forest-bvh-tests.png").unlink(), 2, "forest-bvh-tests.png", "No such file")

    def test_no_image(self):
        self.refuses(lambda f: (f / "images/forest-bvh-tests.png").write_bytes(b"GIF89a"), 3, "forest-bvh-tests.png", "not a PNG")

    def test_image_outside(self):
        self.refuses(self.edit(lambda d: d["scenes"][0]["variants"][0]["images"].update(shaded="../secret.png")), 3, "secret.png")

    def test_output_that_cannot_be_replaced(self):
        def spoil(folder):
            self.edit(lambda d: d["scenes"][0].update(title="Another"))(folder)
            (folder / "report.html").unlink()
            (folder / "report.html").mkdir()
        self.refuses(spoil, 2, "report.html")

    def test_failure_in_the_midst_of_writing(self):
        """Names that are just short enough, but not so the temporary ones."""
        self.refuses(self.edit(lambda d: d["scenes"][1].update(name="s" * 240)), 2, "name too long")

    def test_usage_and_missing_matplotlib(self):
        self.assertEqual(subprocess.run([sys.executable, TOOL / "vcd_report.py"], capture_output=True).returncode, 1)
        without = run(self.folder, "-S")  # without site packages
        self.assertEqual(without.returncode, 4, without.stderr)
        self.assertIn("python3-matplotlib", without.stderr)

    def test_nothing_run_is_a_page_too(self):
        data = fixture.results()
        data["scenes"] = []
        self.make(data)
        self.assertIn("No scene was run.", (self.folder / "report.html").read_text())
        data["scenes"] = [{"name": "alone"}]
        del data["settings"], data["machine"], data["command"], data["version"]
        self.make(data)
        self.assertIn("not run", (self.folder / "report.html").read_text())
