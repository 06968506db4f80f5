"""Headless Chromium on one page, and the questions that the tests ask of it."""
import json
import pathlib
import tempfile

from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

CHROMIUM, DRIVER = pathlib.Path("/usr/bin/chromium"), pathlib.Path("/usr/bin/chromedriver")

CENTRES = """
const centre = e => { const b = e.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2, b.width, b.height]; };
const anchor = e => { const p = new DOMPoint(+e.getAttribute('x'), +e.getAttribute('y')).matrixTransform(e.getScreenCTM()); return [p.x, p.y]; };
return [...document.querySelectorAll('svg[data-x-scale]')].map(svg => ({
  id: svg.id, xScale: svg.dataset.xScale, yScale: svg.dataset.yScale, box: centre(svg),
  points: [...svg.querySelectorAll('.point')].map(p => ({id: p.id, data: {...p.dataset}, tip: p.querySelector('title').textContent,
                                                         at: anchor(p.querySelector('use'))})),
  ticks: [...svg.querySelectorAll('.tick')].map(t => ({data: {...t.dataset}, text: t.textContent.trim(), at: centre(t.querySelector('text'))}))}));
"""
CELLS = """
return [...document.querySelectorAll('table[id]')].map(table => ({id: table.id.slice(6), columns: [...table.querySelectorAll('thead th')].length,
  rows: [...table.querySelectorAll('tr[data-row]')].map(row => ({scene: row.parentNode.dataset.scene || null, row: row.dataset.row,
    head: row.querySelector('th').textContent, cells: [...row.querySelectorAll('td')].map(c => [c.dataset.v ?? null, c.textContent])}))}));
"""


def available():
    return CHROMIUM.exists() and DRIVER.exists()


class Browser:
    def __init__(self, *more):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        options = webdriver.ChromeOptions()
        options.binary_location = str(CHROMIUM)
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
                         "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", f"--user-data-dir={self.profile.name}", *more):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(str(DRIVER)), options=options)
        self.driver.set_script_timeout(60)

    def close(self):
        self.driver.quit()
        self.profile.cleanup()

    def open(self, path, width=1180, height=900, scheme="light"):
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        self.media(scheme)
        self.ask("window.isBefore = true")
        self.driver.get(pathlib.Path(path).as_uri())
        # On a busy machine get() may come back while the page is still being read.
        WebDriverWait(self.driver, 120, ignored_exceptions=[WebDriverException]).until(
            lambda _: self.ask("return !window.isBefore && document.readyState === 'complete'"))

    def media(self, scheme, kind=""):
        self.command("Emulation.setEmulatedMedia", media=kind, features=[{"name": "prefers-color-scheme", "value": scheme}])

    def command(self, name, **parameters):
        return self.driver.execute_cdp_cmd(name, parameters)

    def ask(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def style(self, selector, name):
        return self.ask("return getComputedStyle(document.querySelector(arguments[0]))[arguments[1]]", selector, name)

    def requests(self):
        """Every address that pages from files asked for since the last call; the browser's own first tab asks too."""
        messages = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        return [m["params"]["request"]["url"] for m in messages
                if m["method"] == "Network.requestWillBeSent" and m["params"]["documentURL"].startswith("file:")]

    def complaints(self):
        return self.driver.get_log("browser")
