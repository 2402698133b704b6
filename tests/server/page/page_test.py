#!/usr/bin/env python3
"""The live page in headless Chromium: cards, orbit, modes, picks, cells, prefetch, cool, themes, tokens.

page_test.py SIGHTLINED SIGHTLINE MODEL [--shots DIRECTORY]
"""

import hashlib
import json
import math
import pathlib
import tempfile
import unittest

from browser import Server, chromium
from page_case import PATIENCE, SIGHTLINE, SIGHTLINED, PageCase, run_tests, webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait


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
        self.assertEqual(picked["Node"], row[1])
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

    def ground(self):
        return self.browser.execute_script("return getComputedStyle(document.body).backgroundColor")

    def test_8_light_and_dark(self):
        emulate = "Emulation.setEmulatedMedia"
        light, dark = "rgb(247, 247, 245)", "rgb(20, 23, 26)"
        for system, ground in (("dark", dark), ("light", light)):
            self.browser.execute_cdp_cmd(emulate, {"features": [{"name": "prefers-color-scheme", "value": system}]})
            self.until(lambda ground=ground: self.ground() == ground)
        self.find("#theme option:last-child").click()
        self.until(lambda: self.ground() == dark)
        self.browser.refresh()
        self.until(lambda: self.ground() == dark)
        self.assertEqual(self.find("#theme").get_attribute("value"), "dark")
        self.open_scene()
        self.shot("dark")
        self.check_accessible()
        self.find("#theme option:first-child").click()
        self.until(lambda: self.ground() == light)

    def test_9_accessible_and_without_errors(self):
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
    run_tests("page")
