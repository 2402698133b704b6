"""A server with a scene, and headless Chromium before its page."""

import contextlib
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading

SKIPPED = 77
SYSTEM_PYTHON = "/usr/bin/python3"


def needs_browser():
    """The selenium module, or the end of the test: it is skipped."""
    try:
        import selenium.webdriver as webdriver
    except ImportError as error:
        # The distribution's interpreter sees its packages, which another one first in PATH does not.
        if sys.executable != SYSTEM_PYTHON and pathlib.Path(SYSTEM_PYTHON).exists():
            os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, *sys.argv])
        print(f"skipped: {error}")
        sys.exit(SKIPPED)
    if not pathlib.Path("/usr/bin/chromedriver").exists():
        print("skipped: there is no /usr/bin/chromedriver")
        sys.exit(SKIPPED)
    return webdriver


class Server:
    """sightlined on ports of its own, ended with the block."""

    def __init__(self, sightlined, sightline, arguments=()):
        self.process = subprocess.Popen(
            [sightlined, "--listen", "127.0.0.1:0", "--admin", "127.0.0.1:0", *arguments],
            stderr=subprocess.PIPE, text=True)
        self.log = []
        for line in self.process.stderr:
            self.log.append(line)
            found = re.search(r" port=(\d+) admin_port=(\d+)", line)
            if found:
                break
        else:
            sys.exit("failed: the server did not start\n" + "".join(self.log))
        self.endpoint, self.url = f"127.0.0.1:{found[1]}", f"http://127.0.0.1:{found[2]}/"
        self.sightline = sightline
        threading.Thread(target=lambda: self.log.extend(self.process.stderr), daemon=True).start()

    def run(self, *arguments, stdin=None):
        """The output of the command line."""
        return subprocess.run([self.sightline, "--endpoint", self.endpoint, *arguments], input=stdin, text=True,
                              check=True, capture_output=True).stdout

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        if self.process.wait() != 0:
            sys.exit("failed: the server ended badly\n" + "".join(self.log[-20:]))


@contextlib.contextmanager
def chromium(webdriver, width, height, dark=False):
    """A browser window of that size."""
    from selenium.webdriver.chrome.service import Service
    with tempfile.TemporaryDirectory() as profile:
        options = webdriver.ChromeOptions()
        for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
                     f"--user-data-dir={profile}", f"--window-size={width},{height}"):
            options.add_argument(flag)
        if dark:
            options.add_argument("--force-dark-mode")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        try:
            browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
                "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500})
            yield browser
        finally:
            browser.quit()
