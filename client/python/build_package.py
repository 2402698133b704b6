#!/usr/bin/python3
"""Puts the package together: its sources, the descriptors of the messages, the version.

build_package.py OUT     OUT/sightline is then ready to be imported

Needs protoc. Messages are described by ../../proto, or by proto beside this file in a source archive.
"""

import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
PROTOS = ("google/rpc/status.proto", "google/rpc/error_details.proto", *(
    f"sightline/v1/{name}.proto" for name in ("common", "query", "scene", "backup", "blob", "server")))


def is_archive() -> bool:
    """Whether this is an unpacked source archive, which has what copy_sources() adds."""
    return (HERE / "VERSION").exists()


def root() -> pathlib.Path:
    """Where proto is."""
    return HERE if is_archive() else HERE.parents[1]


def version() -> str:
    """The version that CMakeLists.txt states."""
    if is_archive():
        return (HERE / "VERSION").read_text().strip()
    found = re.search(r"project\(sightline VERSION ([0-9.]+)", (root() / "CMakeLists.txt").read_text())
    if not found:
        sys.exit("CMakeLists.txt names no version")
    return found[1]


def write_data(package: pathlib.Path) -> None:
    """Writes what is not in the sources: descriptors and version."""
    folder = package / "_proto"
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run(["protoc", f"-I{root() / 'proto'}", "--include_imports",
                    f"--descriptor_set_out={folder / 'descriptors.binpb'}", *PROTOS], check=True)
    (folder / "version.txt").write_text(version() + "\n")


def copy_sources(archive: pathlib.Path) -> None:
    """Adds to a source archive what the package is made of besides the files that setuptools knows."""
    for name in PROTOS:
        copy = archive / "proto" / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(root() / "proto" / name, copy)
    shutil.copyfile(HERE / "build_package.py", archive / "build_package.py")
    (archive / "VERSION").write_text(version() + "\n")


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    package = pathlib.Path(sys.argv[1]) / "sightline"
    shutil.rmtree(package, ignore_errors=True)
    shutil.copytree(HERE / "sightline", package, ignore=shutil.ignore_patterns("__pycache__"))
    write_data(package)


if __name__ == "__main__":
    main()
