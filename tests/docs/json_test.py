#!/usr/bin/env python3
"""The commands of docs/operations.md that call in JSON do what it says.

json_test.py SIGHTLINED
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/operations.md"
LISTEN, ADMIN = "--listen 127.0.0.1:50151", "--admin 127.0.0.1:9151"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    if shutil.which("curl") is None:
        print("skipped: there is no curl")
        sys.exit(77)
    section = PAGE.read_text().split("\n## Calls in JSON\n")[1].split("\n## ")[0]
    text = "".join(re.findall(r"^```sh\n(.*?)^```$", section, re.MULTILINE | re.DOTALL))
    for wanted in (LISTEN, ADMIN, "http://127.0.0.1:9151/"):
        assert wanted in text, f"the page has no {wanted}, which this test replaces"
    # The server gets a free port, and its admin port is a Unix socket.
    text = (text.replace(LISTEN, "--listen 127.0.0.1:0 --port-file port").replace(ADMIN, "--admin unix:admin")
            .replace(" &\n", " &\nuntil [ -s port ]; do kill -0 %1; sleep 0.01; done\n")
            .replace("curl ", "curl --unix-socket admin "))
    script = f"set -eum\ntrap 'kill $(jobs -p) 2> /dev/null || true' EXIT\n{text}\nkill %1\nwait %1\n"
    environment = {name: value for name, value in os.environ.items() if not name.startswith("SIGHTLINE")}
    environment["PATH"] = f"{pathlib.Path(sys.argv[1]).resolve().parent}:{environment['PATH']}"
    with tempfile.TemporaryDirectory() as folder:
        ran = subprocess.run(["bash", "-c", script], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    print(ran.stdout, ran.stderr)
    assert ran.returncode == 0, f"exit code {ran.returncode}"
    answers = [json.loads(line) for line in ran.stdout.splitlines() if line.startswith("{")]
    assert answers[0]["scene"]["metersPerUnit"] == 0.001, answers
    assert [scene["name"] for scene in answers[1]["scenes"]] == ["projects/default/scenes/hall"], answers
    assert (answers[2]["error"]["code"], answers[2]["error"]["reason"]) == ("NOT_FOUND", "SCENE_NOT_FOUND"), answers


main()
