#!/usr/bin/env python3
"""An open page and a load test together, for long: whether the server's and the page's memory stay flat.

soak.py SIGHTLINED SIGHTLINE MODEL [--seconds S] [--windows N]

The page orbits the scene all the time, by keys, and cools it once a window, so that trees grow again; `sightline load` casts at it
meanwhile, with updates. Prints a line a window, and the slopes of the server's resident memory, of its open files and of the page's
heap after the first third.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import threading
import time

from browser import Server, chromium, needs_browser

webdriver = needs_browser()
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import WebDriverWait  # noqa: E402

PATIENCE = 60  # seconds
MIB = 1 << 20


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sightlined")
    parser.add_argument("sightline")
    parser.add_argument("model")
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--windows", type=int, default=20)
    return parser.parse_args()


class Load:
    """`sightline load` on the scene, over and over until it is stopped."""

    def __init__(self, server, seconds):
        self.server, self.seconds = server, seconds
        self.runs, self.failed, self.rays = 0, 0, 0.0
        self.stopping = threading.Event()
        self.thread = threading.Thread(target=self.repeat)
        self.thread.start()

    def repeat(self):
        while not self.stopping.is_set():
            rows = json.loads(self.server.run("load", "scene", "--kind", "closest", "--rays", "random", "--clients", "2", "--updates",
                                              "0.05", "--seconds", str(self.seconds), "--json"))["rows"]
            self.runs += 1
            self.failed += sum(row["failed"] for row in rows)
            self.rays += sum(row["rays"] for row in rows)

    def stop(self):
        self.stopping.set()
        self.thread.join()


def resident_mib(process):
    text = pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="utf-8")
    return int(text.split("VmRSS:")[1].split()[0]) / 1024


def open_files(process):
    return len(list(pathlib.Path(f"/proc/{process.pid}/fd").iterdir()))


def heap_mib(browser):
    """Of the page's scripts, after a collection."""
    browser.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
    return browser.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"] / MIB


def slope_per_hour(points):
    """Of the least-squares line through (seconds, value)."""
    mean_x = sum(x for x, _ in points) / len(points)
    mean_y = sum(y for _, y in points) / len(points)
    return 3600 * sum((x - mean_x) * (y - mean_y) for x, y in points) / sum((x - mean_x) ** 2 for x, _ in points)


def orbit(browser, until):
    """Turns the camera until then."""
    picture = browser.find_element(By.ID, "picture")
    keys = [Keys.ARROW_LEFT, Keys.ARROW_LEFT, Keys.ARROW_UP, Keys.ARROW_LEFT, Keys.ARROW_DOWN, "+", "-"]
    turn = 0
    while time.monotonic() < until:
        picture.send_keys(keys[turn % len(keys)])
        turn += 1


def open_page(browser, server):
    browser.get(server.url)
    wait = WebDriverWait(browser, PATIENCE)
    wait.until(lambda _: browser.find_elements(By.CSS_SELECTOR, "#cards button"))
    browser.find_element(By.CSS_SELECTOR, "#cards button").click()
    wait.until(lambda _: browser.find_element(By.ID, "picture").get_attribute("data-coarse") == "none")


def main():
    options = arguments()
    server = Server(options.sightlined, options.sightline)
    server.run("scene", "import", "scene", options.model)
    windows = []
    with chromium(webdriver, 1100, 900) as browser:
        open_page(browser, server)
        load = Load(server, options.seconds / options.windows)
        begun = time.monotonic()
        print("seconds  server MiB  files  page MiB  frames    runs  failed")
        for window in range(1, options.windows + 1):
            orbit(browser, begun + options.seconds * window / options.windows)
            now = (time.monotonic() - begun, resident_mib(server.process), open_files(server.process), heap_mib(browser))
            windows.append(now)
            frames = browser.find_element(By.ID, "picture").get_attribute("data-frames")
            print(f"{now[0]:7.0f} {now[1]:11.1f} {now[2]:6d} {now[3]:9.1f} {frames:>7} {load.runs:7d} {load.failed:7d}", flush=True)
            browser.find_element(By.ID, "cool").click()
        load.stop()
        errors = [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
    server.stop()
    steady = windows[len(windows) // 3:]
    slopes = [slope_per_hour([(one[0], one[column]) for one in steady]) for column in (1, 2, 3)]
    print(f"slopes per hour, after the first third: server {slopes[0]:+.1f} MiB, files {slopes[1]:+.1f}, page {slopes[2]:+.1f} MiB")
    print(f"rays {load.rays:.0f}, failed requests {load.failed}, console errors {len(errors)}")
    sys.exit(1 if load.failed or errors else 0)


if __name__ == "__main__":
    main()
