#!/usr/bin/python3
"""Makes the mistakes of docs/troubleshooting.md and mistakes.md, and compares what is printed with what they show.

troubleshooting_test.py SIGHTLINED SIGHTLINE [--update]    --update: write what is printed into the pages
"""

import contextlib
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PAGES = (HERE.parents[1] / "docs" / "troubleshooting.md", HERE / "mistakes.md")
FEWEST = 60
# Rows of four cells: the mistake, the command, its exit code, what is printed.
ROW = re.compile(r"^\| ([^|]+) \| `((?:[^`|]|\\\|)+)` \| (\d*) \| (.*) \|$", re.MULTILINE)
SHOWN_ENDPOINT, SHOWN_ADMIN = "127.0.0.1:50151", "127.0.0.1:9151"


def npy(dtype, shape, data):
    head = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}"
    head = head.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + data


def make_files(folder):
    """The files that the mistakes are made with."""
    texts = {
        "engine.obj": "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\no piston\nf 1 2 3\nf 1 3 4\n",
        "rays.csv": "0,0.5,9,0,0,-1\n",
        "still.csv": "0,0.5,9,0,0,-1\n0,0.5,9,0,0,0\nnan,0,0,0,0,1\n",
        "short.csv": "0 0.5 9\n",
        "words.csv": "0,0.5,9,0,0,down\n",
        "names.csv": "x,y,z,dx,dy,dz\n0,0.5,9,0,0,-1\n",
        "broken.ndjson": '{"origin": [0, 0, 9]}\n',
        "rays.xyz": "0,0.5,9,0,0,-1\n",
        "empty.glb": "",
        "points.obj": "v 0 0 0\nv 1 0 0\np 1 2\n",
        "ops.ndjson": '{"delete_nodes": {"node": 1}}\n',
        "move.ndjson": '{"delete_node": {"node": 77}}\n',
        "server.toml": 'lisen = "127.0.0.1:0"\n',
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    (folder / "flat.npy").write_bytes(npy("<f8", "(5,)", bytes(40)))
    (folder / "seven.npy").write_bytes(npy("<f8", "(2, 7)", bytes(112)))
    (folder / "complex.npy").write_bytes(npy("<c16", "(1, 6)", bytes(96)))
    (folder / "cut.npy").write_bytes(npy("<f8", "(9, 6)", bytes(100)))
    (folder / "cut.npz").write_bytes(b"PK\x03\x04 and no more")
    with (folder / "huge.obj").open("wb") as huge:
        huge.truncate(1 << 42)
    (folder / "folder").mkdir()
    (folder / "locked").mkdir(mode=0o555)
    folder.chmod(0o755)


@contextlib.contextmanager
def running(folder):
    """A server with one scene; yields its endpoint and that of its admin pages."""
    command = ["sightlined", "--listen", "127.0.0.1:0", "--admin", "127.0.0.1:0", "--data-dir", "data"]
    with subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True) as process:
        try:
            for line in process.stderr:
                found = re.search(r" port=(\d+) admin_port=(\d+)", line)
                if found:
                    break
            else:
                sys.exit("failed: the server did not start")
            yield f"127.0.0.1:{found[1]}", f"127.0.0.1:{found[2]}"
        finally:
            process.terminate()
            process.stderr.read()


def shell(mistake):
    """What runs a command. Nothing is forbidden to root: another user makes mistakes of permission; None if there is no such way."""
    if not mistake.startswith("No permission") or os.geteuid() != 0:
        return ["bash", "-c"]
    return ["setpriv", "--reuid=65534", "--clear-groups", "bash", "-c"] if shutil.which("setpriv") else None


def run(words, command, folder, endpoints):
    """Types the command. Returns its exit code and what it prints, with the ports of the page."""
    for shown, real in endpoints:
        command = command.replace(shown, real)
    # Standard input stays open, as that of a terminal does.
    reader, writer = os.pipe()
    try:
        done = subprocess.run([*words, command], cwd=folder, stdin=reader, text=True, capture_output=True, check=False,
                              timeout=120)
    finally:
        os.close(reader)
        os.close(writer)
    printed = (done.stdout + done.stderr).replace(str(folder) + "/", "")
    for shown, real in endpoints:
        printed = printed.replace(real, shown)
    # Log lines begin with a time and end with what differs from run to run.
    printed = re.sub(r"^\d{4}-\d\d-\d\dT\S+ ", "", printed, flags=re.MULTILINE)
    return done.returncode, printed.rstrip("\n")


def cell_of(printed):
    return "<br>".join("`" + line.replace("|", "\\|").replace("`", "'") + "`" for line in printed.split("\n"))


def main():
    update = sys.argv[3:] == ["--update"]
    if len(sys.argv) != 3 and not update:
        sys.exit(__doc__)
    programs = {pathlib.Path(name).resolve().parent for name in sys.argv[1:3]}
    os.environ["PATH"] = os.pathsep.join([*map(str, programs), os.environ["PATH"]])
    for variable in ("SIGHTLINE_TOKEN", "SIGHTLINE_ENDPOINT"):
        os.environ.pop(variable, None)
    texts = {page: page.read_text() for page in PAGES}
    count, wrong = 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name).resolve()
        make_files(folder)
        with running(folder) as (endpoint, admin):
            endpoints = ((SHOWN_ENDPOINT, endpoint), (SHOWN_ADMIN, admin))
            os.environ["SIGHTLINE_ENDPOINT"] = endpoint
            subprocess.run(["sightline", "scene", "import", "engine", "engine.obj", "--quiet"], cwd=folder, check=True,
                           stdout=subprocess.DEVNULL)
            for page, (mistake, command, exit_code, cell) in [(page, row) for page in PAGES for row in ROW.findall(texts[page])]:
                count += 1
                words = shell(mistake)
                if words is None:
                    continue
                code, printed = run(words, command.replace("\\|", "|"), folder, endpoints)
                row = f"| {mistake} | `{command}` | {exit_code} | {cell} |"
                new = f"| {mistake} | `{command}` | {code} | {cell_of(printed)} |"
                if row != new:
                    wrong += 1
                    print(f"- {row}\n+ {new}\n")
                    texts[page] = texts[page].replace(row, new)
    if update:
        for page, text in texts.items():
            page.write_text(text)
        return
    print(f"{count} mistakes, {wrong} print something else than the pages say")
    sys.exit(1 if wrong or count < FEWEST else 0)


if __name__ == "__main__":
    main()
