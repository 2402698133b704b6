#!/usr/bin/python3
"""The README's first query runs as it is shown, in shell, Python and C++, against one server.

readme_test.py SIGHTLINED SIGHTLINE FIRST_QUERY PACKAGE    PACKAGE: the folder of the Python package

Without grpcio and numpy the Python part is left out; 77 where the engine's model is not installed.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"


def section():
    return re.search(r"^## A first query\n(.*?)^## ", README.read_text(), re.MULTILINE | re.DOTALL)[1]


def fenced(language):
    """The blocks of a language, in order."""
    return re.findall(rf"^```{language}\n(.*?)^```$", section(), re.MULTILINE | re.DOTALL)


def shown():
    """The lines of output that the section shows: they are indented."""
    return re.findall(r"^    (\S.*)$", re.sub(r"^```.*?^```$", "", section(), flags=re.MULTILINE | re.DOTALL), re.MULTILINE)


def has_python():
    try:
        import google.protobuf
        import grpc
        import numpy
    except ImportError as missing:
        print(f"the Python part is left out: {missing}")
        return False
    return bool(google.protobuf and grpc and numpy)


def script(first_query):
    """What a reader types. The line that sets PATH is left out: here PATH has the programs of this build."""
    commands = [block for block in fenced("sh") if not block.startswith("export PATH")]
    # A server that outlives a failure would keep this test waiting for the end of its output.
    lines = ["set -em", "trap 'kill $(jobs -p) 2> /dev/null || true' EXIT", *commands]
    if has_python():
        lines += ["/usr/bin/python3 first_query.py"]
    return "\n".join([*lines, f"{first_query} $SIGHTLINE_ENDPOINT", "kill %1", "wait %1", ""])


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    sightlined, sightline, first_query, package = (pathlib.Path(name).resolve() for name in sys.argv[1:])
    model = re.search(r"/usr/share/\S+", section())[0]
    if not os.path.exists(model):
        print(f"skipped: {model} is missing")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        # A server of the test's own, at a socket instead of the default port, which another one may have.
        endpoint = f"unix:{folder}/socket"
        environment = {name: value for name, value in os.environ.items() if not name.startswith("SIGHTLINE")}
        environment.update(SIGHTLINED_LISTEN=endpoint, SIGHTLINE_ENDPOINT=endpoint, PYTHONPATH=str(package),
                           PATH=f"{sightlined.parent}:{sightline.parent}:{os.environ['PATH']}")
        pathlib.Path(folder, "first_query.py").write_text("".join(fenced("python")))
        ran = subprocess.run(["bash", "-c", script(first_query)], cwd=folder, env=environment, capture_output=True,
                             text=True)
        print(ran.stdout, ran.stderr)
        assert ran.returncode == 0, f"exit code {ran.returncode}"
        assert len(shown()) == 4
        for line in shown():
            assert line in ran.stdout, f"this is shown, and was not printed: {line}"
        assert pathlib.Path(folder, "engine.png").read_bytes().startswith(b"\x89PNG")
        by_cpp = re.search(r"(\d+) of 75 rays hit, at revision", ran.stdout)[1]
        highest = max(map(float, re.findall(r"height +([\d.]+)", ran.stdout)))
        if has_python():
            assert f"{by_cpp} of 75 rays hit, the highest at {highest:.1f}: " in ran.stdout


if __name__ == "__main__":
    main()
