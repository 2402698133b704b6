#!/usr/bin/python3
"""The C++ that docs/cpp.md shows is in docs/game_loop.cpp, which prints what it should beside a server.

cpp_test.py SIGHTLINED GAME_LOOP
"""

import pathlib
import re
import subprocess
import sys

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
FEWEST = 4  # blocks


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sightlined, game_loop = (pathlib.Path(name).resolve() for name in sys.argv[1:])
    program = (DOCS / "game_loop.cpp").read_text()
    blocks = re.findall(r"^```cpp\n(.*?)^```$", (DOCS / "cpp.md").read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) >= FEWEST
    for block in blocks:
        assert block in program, f"docs/cpp.md shows what is not in docs/game_loop.cpp:\n{block}"
    command = [sightlined, "--listen", "127.0.0.1:0", "--admin", "127.0.0.1:0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        try:
            ports = (re.search(r" port=(\d+) admin_port=", line) for line in server.stderr)
            port = next(found[1] for found in ports if found)
            ran = subprocess.run([game_loop, f"127.0.0.1:{port}"], capture_output=True, text=True)
        finally:
            server.terminate()
            server.stderr.read()
    print(ran.stdout, ran.stderr)
    assert ran.returncode == 0
    ticks = [f"tick {tick}: node 1 is {9 + tick} below" for tick in range(5)]
    assert ran.stdout.splitlines() == ["before: node 1 is 9 below", *ticks]


if __name__ == "__main__":
    main()
