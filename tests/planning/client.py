#!/usr/bin/env python3
"""One client: sends its next request when the one before is answered. A process of its own, so that clients do not share an interpreter.

Reads a line of JSON: endpoint, scenes (names), shares (of requests), requests, rays, window, seed. Says "ready", waits for a line, sends
all requests, and prints a line of JSON: began and ended (monotonic), responses_s, cpu_s.
"""
import json
import sys
import time

import numpy as np
import sightline

from terrain import window_rays


def main():
    task = json.loads(sys.stdin.readline())
    random = np.random.default_rng(task["seed"])
    chosen = random.choice(len(task["scenes"]), task["requests"], p=task["shares"])
    batches = [window_rays(random, task["rays"], task["window"]) for _ in range(task["requests"])]
    client = sightline.connect(task["endpoint"], token="")
    client.max_rays_per_request()
    scenes = [client.scene(name) for name in task["scenes"]]
    print("ready", flush=True)
    sys.stdin.readline()
    responses = []
    began, cpu = time.monotonic(), time.process_time()
    last = began
    for scene, rays in zip(chosen, batches):
        scenes[scene].cast(rays, fields=("t", "node", "primitive"))
        now = time.monotonic()
        responses.append(now - last)
        last = now
    print(json.dumps({"began": began, "ended": last, "responses_s": responses, "cpu_s": time.process_time() - cpu}), flush=True)


if __name__ == "__main__":
    main()
