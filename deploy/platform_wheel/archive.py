"""A wheel for this machine's platform, made of the wheel without programs, the programs, and their libraries."""

import os
import pathlib
import platform
import re
import shutil
import sys
import tempfile

from .check import SEARCH_PATH, check_files, check_versions
from .commands import Failure, output_of
from .libraries import bundled_by
from .licences import write_licences

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "client/python/sightline_programs"


def tag():
    """What pip compares with the machine that it installs to: the C library's version is the least that is enough."""
    match = re.fullmatch(r"glibc (\d+)\.(\d+)", os.confstr("CS_GNU_LIBC_VERSION") or "")
    if not match:
        raise Failure("wheels of programs need the GNU C library, which this system does not have")
    return f"py3-none-manylinux_{match[1]}_{match[2]}_{platform.machine()}"


def add_programs(package, programs):
    """Copies programs to package/bin and their libraries to package/lib. Returns the libraries: {name: path}."""
    libraries = bundled_by(programs)
    for name in ("bin", "lib"):
        (package / name).mkdir()
    for program in programs:
        copy = package / "bin" / program.name
        shutil.copyfile(program, copy)
        copy.chmod(0o755)
        # Stripping comes first: it may spoil what patchelf has moved.
        output_of("strip", copy)
        output_of("patchelf", "--force-rpath", "--set-rpath", SEARCH_PATH, copy)
    for name, path in libraries.items():
        copy = package / "lib" / name
        shutil.copyfile(path, copy)
        copy.chmod(0o644)
        output_of("strip", "--strip-unneeded", copy)
    return libraries


def describe(information, platform_tag, names):
    """Changes what the wheel says of itself: its platform, that it holds programs, and the commands to be made."""
    file = information / "WHEEL"
    text = re.sub(r"^Root-Is-Purelib:.*$", "Root-Is-Purelib: false", file.read_text(), flags=re.MULTILINE)
    file.write_text(re.sub(r"^Tag:.*$", f"Tag: {platform_tag}", text, flags=re.MULTILINE))
    commands = "".join(f"{name} = {PACKAGE.name}:{name}\n" for name in names)
    (information / "entry_points.txt").write_text(f"[console_scripts]\n{commands}")
    with (information / "top_level.txt").open("a") as packages:
        packages.write(f"{PACKAGE.name}\n")


def make_wheel(pure_wheel, programs, out):
    """Writes the wheel into the folder `out`, in place of any of the same name, and returns its path."""
    programs = [pathlib.Path(program) for program in programs]
    version = pure_wheel.name.split("-")[1]
    with tempfile.TemporaryDirectory(prefix="sightline-wheel-") as scratch:
        output_of(sys.executable, "-m", "wheel", "unpack", "--dest", scratch, pure_wheel)
        content = next(pathlib.Path(scratch).iterdir())
        information = next(content.glob("*.dist-info"))
        package = content / PACKAGE.name
        shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
        libraries = add_programs(package, programs)
        check_files(package)
        check_versions(package, version)
        licences = information / "licenses"
        licences.mkdir()
        shutil.copyfile(ROOT / "LICENSE", licences / "LICENSE")
        write_licences(libraries, licences)
        platform_tag = tag()
        describe(information, platform_tag, [program.name for program in programs])
        out.mkdir(parents=True, exist_ok=True)
        output_of(sys.executable, "-m", "wheel", "pack", "--dest-dir", out, content)
    return out / f"sightline-{version}-{platform_tag}.whl"
