"""What the parts of the report's test share."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import fixture

try:
    import matplotlib
except ImportError:
    matplotlib = None
try:
    import page_browser
except ImportError:
    page_browser = None

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "lab" / "report"
BROWSER = page_browser is not None and page_browser.available()
WHY = "needs python3-matplotlib; tools/install_dependencies.sh lab installs it"
WHY_BROWSER = "needs chromium, chromium-driver, python3-selenium, python3-matplotlib; tools/install_dependencies.sh lab installs them"


def run(folder, *options):
    return subprocess.run([sys.executable, *options, TOOL / "vcd_report.py", folder], capture_output=True, text=True, timeout=300)


def files(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def configurations(scene):
    return [v for v in scene["variants"] if "samples" in v or "method" in v]


def sampled(scene):
    return [v for v in scene["variants"] if "samples" in v]


class Case(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name) / "run with spaces"

    def make(self, data=None, code=0, says="", hard=None):
        fixture.write(self.folder, data, hard)
        done = run(self.folder)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        self.assertIn(says, done.stderr)
        return done


class MadeCase(Case):
    """One report, made once for all tests of the case; nothing may be written there."""
    hard = None

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.made = pathlib.Path(holder.name)
        fixture.write(cls.made, hard=cls.hard)
        done = run(cls.made)
        assert done.returncode == 0, done.stderr
        cls.report = json.loads((cls.made / "report.json").read_text())


@unittest.skipUnless(matplotlib and BROWSER, WHY_BROWSER)
class PageCase(unittest.TestCase):
    """One page, opened anew for each test."""

    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        folder = pathlib.Path(cls.holder.name)
        cls.hard = fixture.stability()
        cls.data = fixture.write(folder, hard=cls.hard)
        done = run(folder)
        assert done.returncode == 0, done.stderr
        shutil.rmtree(folder / "images")  # the page must not need them any more
        cls.page = folder / "report.html"
        cls.report = json.loads((folder / "report.json").read_text())
        cls.browser = page_browser.Browser()
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        self.browser.open(self.page)
