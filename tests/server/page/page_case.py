"""A server with a scene, and its page in a browser, for the tests of the page.

A file of tests is called with SIGHTLINED SIGHTLINE MODEL [--shots DIRECTORY].
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

from browser import Server, chromium, needs_browser

webdriver = needs_browser()
from selenium.webdriver.common.by import By  # noqa: E402
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


def run_tests(name):
    """Runs the tests of the main file, and ends the process."""
    began = time.monotonic()
    result = unittest.main(argv=sys.argv[:1], exit=False, verbosity=2).result
    print(f"{name}: {result.testsRun} tests, {time.monotonic() - began:.0f} s")
    sys.exit(0 if result.wasSuccessful() else 1)
