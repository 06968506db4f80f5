"""How the page looks and behaves: phone, dark, paper, pictures, words."""
import re

from report_case import PageCase


class Page(PageCase):
    def test_loads_nothing_and_says_nothing(self):
        self.browser.requests(), self.browser.complaints()
        self.browser.open(self.page)
        asked = [u for u in self.browser.requests() if not u.startswith("data:")]
        self.assertEqual(asked, [self.page.as_uri()])
        self.assertEqual(self.browser.complaints(), [])
        self.assertEqual(self.browser.ask("return document.querySelectorAll('img').length"), 8)
        self.assertTrue(self.browser.ask("return [...document.images].every(i => i.naturalWidth === 240)"))
        self.assertTrue(self.browser.ask("const ids = [...document.querySelectorAll('[id]')].map(e => e.id); return new Set(ids).size === ids.length"))

    def test_not_run_says_so(self):
        text = self.browser.ask("return document.querySelector('#speedup .absent').textContent")
        self.assertIn("lost.ply: cannot be read", text)
        self.assertIn("not run", self.browser.ask("return document.querySelector('#kinds .absent').textContent"))
        self.assertEqual(self.browser.ask("return document.querySelectorAll('ball').length"), 0)
        self.assertIn('Hair <ball> & "co"', self.browser.ask("return document.querySelector('#compare-hairball h3').textContent"))

    def test_phone(self):
        self.browser.open(self.page, 360, 740)
        self.browser.ask("for (const d of document.querySelectorAll('details')) d.open = true")
        self.assertEqual(self.browser.ask("return document.documentElement.scrollWidth"), 360)
        outside = self.browser.ask("""return [...document.body.querySelectorAll('*')].filter(e => !e.closest('.scroll') && !e.closest('svg')
            && e.getBoundingClientRect().right > 360.5).map(e => e.tagName + '.' + e.className)""")
        self.assertEqual(outside, [])
        left = self.browser.ask("return [...document.querySelectorAll('.panel')].map(p => p.getBoundingClientRect().left)")
        self.assertEqual(len(set(left)), 1, "one column")
        texts = self.browser.ask("""return [...document.querySelectorAll('svg[data-x-scale]')].map(s => {
              const box = s.getBoundingClientRect();
              return [s.id, Math.min(...[...s.querySelectorAll('text')].map(t => parseFloat(getComputedStyle(t).fontSize) * box.width / s.viewBox.baseVal.width)),
                      Math.max(...[...s.querySelectorAll('text')].map(t => t.getBoundingClientRect().right))]; })""")
        self.assertEqual(len(texts), len(self.report["charts"] + self.report["stability"]["charts"]))
        for text in texts:
            self.assertGreaterEqual(text[1], 10, text[0])
            self.assertLessEqual(text[2], 360, text[0])

    def test_slider_and_choice(self):
        figure = "#compare-killeroo"
        clip = lambda: self.browser.style(f"{figure} img.right", "clipPath")
        self.assertIn("50%", clip())
        self.browser.ask(f"const r = document.querySelector('{figure} input'); r.value = 20; r.dispatchEvent(new Event('input'))")
        self.assertIn("20%", clip())
        x, y, width, height = self.browser.ask(f"""const s = document.querySelector('{figure} .stage'); s.scrollIntoView({{block: 'center'}});
            const b = s.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]""")
        for kind, share in (("mousePressed", 0.3), ("mouseMoved", 0.75), ("mouseReleased", 0.75)):
            self.browser.command("Input.dispatchMouseEvent", type=kind, x=x + width * share, y=y + height / 2, button="left",
                                 buttons=1, clickCount=1)
        self.assertIn("75%", clip())
        before = self.browser.ask(f"return document.querySelector('{figure} img.right').src")
        keys = self.browser.ask(f"return [...document.querySelectorAll('{figure} .choose-right option')].map(o => o.value)")
        self.assertEqual(set(keys), {f"{v['id']}/{w}" for v in self.data["scenes"][0]["variants"] for w in v.get("images", {})})
        self.browser.ask(f"const s = document.querySelector('{figure} .choose-right'); s.value = 'd6-n81/difference'; s.dispatchEvent(new Event('change'))")
        self.assertNotEqual(self.browser.ask(f"return document.querySelector('{figure} img.right').src"), before)
        caption = self.browser.ask(f"return document.querySelector('{figure} .says-right').textContent")
        variant = next(v for v in self.data["scenes"][0]["variants"] if v["id"] == "d6-n81")
        found = re.fullmatch(r"depth 6, 81 samples: difference from the BVH × 20, RMSE (\S+), largest (\S+)", caption)
        self.assertIsNotNone(found, caption)
        self.assertAlmostEqual(float(found[1]), variant["rmse"], delta=1e-5)
        self.assertAlmostEqual(float(found[2]), variant["max_difference"], delta=1e-3)

    def colours(self):
        point = "#chart-speedup-killeroo .point use"
        return [self.browser.style("body", "backgroundColor"), self.browser.style("h1", "color"), self.browser.style(point, "fill"),
                self.browser.style("#chart-speedup-killeroo text", "fill")]

    def test_dark(self):
        light = self.colours()
        self.browser.media("dark")
        dark = self.colours()
        for a, b in zip(light, dark):
            self.assertNotEqual(a, b)
        for ground, ink in (light[:2], dark[:2]):
            self.assertGreater(contrast(ground, ink), 7)
        for ground, point in ((light[0], light[2]), (dark[0], dark[2])):
            self.assertGreater(contrast(ground, point), 3)

    def test_print(self):
        self.browser.media("dark", "print")
        self.assertEqual(self.browser.style("body", "backgroundColor"), "rgb(255, 255, 255)")
        self.assertEqual(self.browser.style("#compare-killeroo input", "display"), "none")
        self.assertEqual(self.browser.style("#compare-killeroo img.right", "clipPath"), "none")
        self.assertEqual(contrast("rgb(255, 255, 255)", self.browser.style("#chart-speedup-killeroo text", "fill")) > 4.5, True)
        self.browser.ask("dispatchEvent(new Event('beforeprint'))")
        self.assertTrue(self.browser.ask("""return [...document.querySelectorAll('table[id]')].every(t =>
            t.checkVisibility({contentVisibilityAuto: true}) && t.getBoundingClientRect().height > 0)"""))
        self.browser.ask("dispatchEvent(new Event('afterprint'))")
        self.assertEqual(self.browser.ask("return document.querySelectorAll('details[open]').length"), 0)
        self.browser.command("Emulation.setDeviceMetricsOverride", width=703, height=1000, deviceScaleFactor=1, mobile=False)  # A4 within its margins
        self.browser.ask("dispatchEvent(new Event('beforeprint'))")
        wide = self.browser.ask("return [...document.querySelectorAll('table')].map(t => t.getBoundingClientRect().right).filter(r => r > 704)")
        self.assertEqual(wide, [], "tables wider than the paper")

    def test_described_for_those_who_do_not_see_it(self):
        bare = self.browser.ask("""return [
            [...document.images].filter(i => !i.alt).length, [...document.querySelectorAll('table')].filter(t => !t.caption).length,
            [...document.querySelectorAll('th')].filter(t => !t.scope).length, [...document.querySelectorAll('svg')].filter(s => s.getAttribute('role') !== 'img').length,
            [...document.querySelectorAll('svg')].filter(s => s.getAttribute('aria-labelledby').split(' ').some(i => !document.getElementById(i)?.textContent)).length,
            [...document.querySelectorAll('select, input')].filter(e => !e.labels.length && !e.getAttribute('aria-label')).length,
            document.documentElement.lang === 'en' ? 0 : 1]""")
        self.assertEqual(bare, [0] * 7)

    def test_how_it_was_measured_stands_under_every_figure(self):
        missing = self.browser.ask("""return [...document.querySelectorAll('.panels, .compare:not(.absent)')].filter(f =>
            !((f.querySelector('.measured') || f.nextElementSibling)?.textContent || '').includes('Made-up Processor 9')).length""")
        self.assertEqual(missing, 0)
        facts = self.browser.ask("return document.querySelector('.facts').textContent")
        for text in ("vc-bench --quick -o out", "GCC 12.2.0", "3.13.5 AVX-512", "240 × 160", "pinned"):
            self.assertIn(text, facts)

    def test_trends_on_the_page(self):
        rows = self.browser.ask("return [...document.querySelectorAll('#trend-tests-fall-with-depth tr[data-scene]')].map(r => r.innerText)")
        self.assertIn("does not hold here; it does in the paper", rows[1])
        steps = self.browser.ask("return [...document.querySelectorAll('#trend-tests-fall-with-depth details tbody [data-v]')].map(e => Number(e.dataset.v))")
        self.assertEqual(steps[1:], [1e9, 1015e6, 959e6])

    def test_the_look_ups_own_cost(self):
        items = self.browser.ask("return [...document.querySelectorAll('#unclassified li')].map(e => e.textContent)")
        self.assertRegex(items[0], r"Killeroo: shadow rays take 1\.04× .*the image is identical")
        self.assertEqual(items[3], "Forest: not run.")


def contrast(a, b):
    def luminance(colour):
        parts = [int(c) / 255 for c in re.findall(r"\d+", colour)[:3]]
        r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts)
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    low, high = sorted((luminance(a), luminance(b)))
    return (high + 0.05) / (low + 0.05)
