"""What the tests of deploy/ share: its files, a running server, and programs that may be missing."""

import contextlib
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.request

sys.dont_write_bytecode = True
SKIPPED = 77
DEPLOY = pathlib.Path(__file__).resolve().parent.parent.parent / "deploy"


def needs(program):
    """Ends the test as skipped where a program is missing."""
    if shutil.which(program) is None:
        print(f"skipped: there is no {program}")
        sys.exit(SKIPPED)


def run(*command):
    """Runs a program; prints its output and ends the test as failed where it fails. Returns the output."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        print(done.stdout)
        sys.exit(f"failed: {' '.join(map(str, command))}")
    return done.stdout


@contextlib.contextmanager
def server(program, *flags):
    """A running server on free ports, and the URL of its admin port."""
    command = [program, "--listen", "127.0.0.1:0", "--admin", "127.0.0.1:0", "--threads", "1", *flags]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            for line in process.stderr:
                found = re.search(r" admin_port=(\d+)", line)
                if found:
                    yield f"http://127.0.0.1:{found[1]}"
                    break
            else:
                sys.exit("failed: the server did not start")
        finally:
            process.terminate()
            process.stderr.read()


def metrics(url):
    """The text of all metrics of a server."""
    with urllib.request.urlopen(url + "/metrics", timeout=30) as reply:
        return reply.read().decode()


def metric_names(text):
    """The names of all series: those of a histogram have endings."""
    return {re.match(r"\w+", line)[0] for line in text.splitlines() if line and not line.startswith("#")}
