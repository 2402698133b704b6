#!/usr/bin/env python3
"""The live page in headless Chromium: cards, orbit, modes, picks, cells, prefetch, cool, tokens.

page_test.py SIGHTLINED SIGHTLINE MODEL [--shots DIRECTORY]
"""

import hashlib
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

from browser import Server, chromium, needs_browser

webdriver = needs_browser()
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

PATIENCE = 60  # seconds: only a test that fails takes them
SCENE = "projects/default/scenes/engine"
SIGHTLINED, SIGHTLINE, MODEL = sys.argv[1:4]
SHOTS = pathlib.Path(sys.argv[5]) if "--shots" in sys.argv else None


def axe_source():
    """The text of axe-core, or None where npm cannot fetch it."""
    npm = shutil.which("npm")
    if npm is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([npm, "pack", "axe-core@4"], cwd=folder, capture_output=True, check=False)
        if done.returncode != 0:
            return None
        subprocess.run("tar xzf axe-core-*.tgz", shell=True, cwd=folder, check=True)
        return pathlib.Path(folder, "package/axe.min.js").read_text(encoding="utf-8")


class PageCase(unittest.TestCase):
    """A server with one scene, none of it built, and its page."""

    size = (1100, 900)
    arguments = ()

    @classmethod
    def setUpClass(cls):
        cls.server = Server(SIGHTLINED, SIGHTLINE, cls.arguments)
        cls.addClassCleanup(cls.server.stop)
        cls.server.run("scene", "import", "engine", MODEL)
        cls.browser = cls.enterClassContext(chromium(webdriver, *cls.size))
        cls.browser.get(cls.server.url)

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector):
        return self.find(selector).text

    def until(self, condition):
        """Waits until condition() is true, and returns what it returned."""
        return WebDriverWait(self.browser, PATIENCE).until(lambda _: condition())

    def open_scene(self):
        self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#cards button"))
        if not self.find("#viewer").is_displayed():
            self.find("#cards button").click()
        self.sharp()

    def sharp(self):
        """Waits until the camera rests and the picture is as fine as it gets."""
        self.until(lambda: self.find("#picture").get_attribute("data-coarse") == "none")

    def picture(self):
        """A digest of the pixels."""
        return self.browser.execute_script("return document.getElementById('picture').toDataURL()")

    def facts(self, selector):
        """The rows of a list of terms."""
        rows = self.browser.execute_script(
            "return [...document.querySelectorAll(arguments[0])].map(one => one.textContent)",
            f"{selector} dt, {selector} dd")
        return dict(zip(rows[::2], rows[1::2]))

    def shot(self, name):
        if SHOTS:
            SHOTS.mkdir(parents=True, exist_ok=True)
            self.browser.save_screenshot(str(SHOTS / f"{name}.png"))

    def check_accessible(self):
        """By axe-core; the test is skipped where npm cannot fetch it."""
        source = axe_source()
        if source is None:
            self.skipTest("npm cannot fetch axe-core")
        self.browser.execute_script(source)
        found = self.browser.execute_async_script("axe.run().then(arguments[0])")
        self.assertEqual([(one["id"], [node["html"] for node in one["nodes"]]) for one in found["violations"]], [])

    def errors(self):
        return [entry for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]


class Page(PageCase):
    def test_1_a_card_for_each_scene_that_builds_nothing(self):
        self.until(lambda: "0 % built" in self.text("#cards"))
        self.assertIn("engine", self.text("#cards button .name"))
        self.assertEqual(self.text("#cards .note"), "nothing built yet")
        self.assertEqual(json.loads(self.server.run("stats", "engine", "--json"))["triangles_built"], 0)

    def test_2_cells_disappear_as_rays_build_them(self):
        self.open_scene()
        self.until(lambda: "Deferred cells" in self.facts("#built"))
        seen = self.find("#picture").get_attribute("data-first-frame")
        print(f"first frame after ms {seen}")
        self.until(lambda: self.facts("#built").get("Triangles built", "0 ").split()[0] != "0")
        self.shot("lit")

    def test_3_modes_change_the_colours(self):
        self.open_scene()
        pictures = {self.picture()}
        for mode in ("normal", "depth", "node", "heat"):
            self.find(f"input[value={mode}]").click()
            self.browser.execute_script("document.getElementById('picture').dataset.coarse = ''")
            self.sharp()
            pictures.add(self.picture())
            self.shot(mode)
        self.assertEqual(len(pictures), 5)
        self.find("input[value=lit]").click()
        self.sharp()

    def pixel_ray(self, x, y):
        """Origin and direction of a pixel of the first view, by the page's own camera."""
        scene = json.loads(self.server.run("scene", "show", "engine", "--json"))
        return self.browser.execute_async_script("""
            const [bounds, upAxis, x, y, done] = arguments;
            import('/page/camera.js').then(({Camera, add, scale}) => {
              const p = new Camera({bounds, up_axis: upAxis}, 640 / 400).pinhole(640, 400);
              done([p.eye, add(p.corner, add(scale(p.across, (x + 0.5) / 640), scale(p.down, (y + 0.5) / 400)))]);
            });""", scene["bounds"], 2 if scene.get("up_axis") in ("z", "Z") else 1, x, y)

    def test_4_a_pick_equals_a_cast(self):
        self.open_scene()
        self.find("#whole").click()
        self.sharp()
        ActionChains(self.browser).move_to_element(self.find("#picture")).click().perform()
        self.until(lambda: "Node" in self.facts("#picked"))
        picked = self.facts("#picked")
        x, y = (int(part) for part in picked["Pixel"].split(","))
        eye, direction = self.pixel_ray(x, y)
        length = math.sqrt(sum(d * d for d in direction))
        ray = ",".join(repr(v) for v in [*eye, *(d / length for d in direction)])
        row = self.server.run("cast", "engine", "--in", "-", "--out", "-", "--fields", "t,node,primitive",
                              stdin=ray + "\n").strip().split("\n")[-1].split(",")
        self.assertEqual(picked["Node"].split()[0], row[1])
        self.assertEqual(picked["Primitive"], row[2])
        self.assertAlmostEqual(float(picked["t"]), float(row[0]), delta=1e-9 * float(row[0]))

    def test_5_orbits_by_mouse_and_keyboard(self):
        self.open_scene()
        before = self.picture()
        canvas = self.find("#picture")
        ActionChains(self.browser).click_and_hold(canvas).move_by_offset(60, 20).release().perform()
        self.until(lambda: self.picture() != before)
        for key in (Keys.ARROW_LEFT, Keys.ARROW_UP, "+", "-", Keys.HOME):
            before = self.picture()
            canvas.send_keys(key)
            self.until(lambda: self.picture() != before)
        canvas.send_keys(Keys.ENTER)
        self.until(lambda: self.facts("#picked").get("Pixel") == "320, 200")

    def test_6_prefetch_builds_all_and_cool_drops_it(self):
        self.open_scene()
        self.find("#prefetch").click()
        self.until(lambda: "all trees are built" in self.text("#action"))
        self.until(lambda: self.facts("#built")["Deferred cells"] == "0")
        self.find("#cool").click()
        self.until(lambda: "dropped" in self.text("#action"))
        self.until(lambda: self.facts("#built")["Triangles built"].split()[0] == "0")

    def test_7_counters_and_log_live(self):
        self.until(lambda: "event=started" in self.text("#log"))
        before = self.text("#counters")
        self.until(lambda: self.text("#counters") != before)

    def test_8_accessible_and_without_errors(self):
        self.open_scene()
        self.assertEqual(self.errors(), [])
        self.check_accessible()


class SmallPage(PageCase):
    size = (360, 740)

    def test_fits_a_phone(self):
        self.open_scene()
        self.shot("phone")
        wide = self.browser.execute_script("return document.documentElement.scrollWidth")
        self.assertLessEqual(wide, 360)
        before = self.picture()
        self.browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": True})
        box = self.find("#picture").rect
        x, y = box["x"] + box["width"] / 2, box["y"] - self.browser.execute_script("return scrollY") + box["height"] / 2
        for kind, dx in (("touchStart", 0), ("touchMove", 30), ("touchMove", 60), ("touchEnd", 60)):
            points = [] if kind == "touchEnd" else [{"x": x + dx, "y": y}]
            self.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        self.until(lambda: self.picture() != before)
        self.assertEqual(self.errors(), [])
        self.check_accessible()


class GuardedPage(unittest.TestCase):
    def test_asks_for_a_token(self):
        token = "a-token-of-32-characters-or-more"
        with tempfile.TemporaryDirectory() as folder:
            tokens = pathlib.Path(folder, "tokens.toml")
            digest = hashlib.sha256(token.encode()).hexdigest()
            tokens.write_text(f'[[token]]\nname = "viewer"\nsha256 = "{digest}"\nrole = "read"\nscenes = [""]\n',
                              encoding="utf-8")
            server = Server(SIGHTLINED, SIGHTLINE, ("--tokens", str(tokens)))
            try:
                with chromium(webdriver, 800, 600) as browser:
                    browser.get(server.url)
                    wait = WebDriverWait(browser, PATIENCE)
                    form = browser.find_element(By.ID, "token-form")
                    wait.until(lambda _: form.is_displayed())
                    field, state = browser.find_element(By.ID, "token"), browser.find_element(By.ID, "state")
                    field.send_keys("geh\u00efm" + Keys.ENTER)
                    wait.until(lambda _: "visible ASCII" in state.text)
                    browser.execute_script("location.hash = '#%E0%A4%A'")  # it is no encoded text
                    wait.until(lambda _: browser.find_element(By.ID, "viewer").is_displayed())
                    field.clear()
                    field.send_keys(token + Keys.ENTER)
                    wait.until(lambda _: "%E0%A4%A" in state.text)
                    browser.execute_script("location.hash = ''")
                    wait.until(lambda _: not form.is_displayed())
                    wait.until(lambda _: browser.find_element(By.ID, "server").text)
                    wait.until(lambda _: "administrators" in browser.find_element(By.ID, "log").text)
            finally:
                server.stop()
            self.assertFalse(any(token in line for line in server.log))


if __name__ == "__main__":
    began = time.monotonic()
    result = unittest.main(argv=sys.argv[:1], exit=False, verbosity=2).result
    print(f"page: {result.testsRun} tests, {time.monotonic() - began:.0f} s")
    sys.exit(0 if result.wasSuccessful() else 1)
