"""The programs that the local cluster runs: Debian's, and sightlined from PATH or from a build of this checkout."""

import os
import pathlib
import shutil
import subprocess
import sys

from .settings import Failure, say

DEPLOY = pathlib.Path(__file__).resolve().parent.parent
_ROOT = DEPLOY.parent


def install_packages(*sections):
    """Those of deploy/packages.txt that are missing."""
    done = subprocess.run([DEPLOY / "install-packages", *sections], stdout=sys.stderr, check=False)
    if done.returncode != 0:
        raise Failure("the packages were not installed")


def find(name):
    """Programs of system services are not in the PATH of every user."""
    found = shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin:/usr/local/sbin")
    if found is None:
        raise Failure(f"there is no {name}")
    return found


def postgres(name):
    """A program of the newest PostgreSQL from 15 on, where Debian has them."""
    for folder in sorted(pathlib.Path("/usr/lib/postgresql").glob("*/bin"), key=_version, reverse=True):
        if _version(folder) >= 15 and os.access(folder / name, os.X_OK):
            return folder / name
    raise Failure(f"there is no PostgreSQL from version 15 on ({name})")


def _version(folder):
    return int(folder.parent.name) if folder.parent.name.isdigit() else 0


def sightlined(wanted):
    """`wanted`, or SIGHTLINED, or that of PATH, or that of a build, which is made if there is none."""
    wanted = wanted or os.environ.get("SIGHTLINED")
    if wanted:
        found = shutil.which(wanted)
        if found is None:
            raise Failure(f"{wanted} is not a program")
        return pathlib.Path(found).resolve()
    built = _ROOT / "build/release/server/sightlined"
    tested = _ROOT / "build/tests/server/sightlined"
    found = shutil.which("sightlined") or next((str(path) for path in (built, tested) if path.exists()), None)
    if found is None:
        _build()
        found = str(built)
    return pathlib.Path(found).resolve()


def _build():
    say("building sightlined and sightline (a few minutes)")
    install_packages("build")
    for command in (["cmake", "-S", ".", "-B", "build/release", "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release"],
                    ["cmake", "--build", "build/release", "--target", "sightlined", "sightline"]):
        done = subprocess.run(command, cwd=_ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode != 0:
            raise Failure(f"{' '.join(command)} failed:\n{done.stdout[-4000:]}")
