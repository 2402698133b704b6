"""Which libraries programs need, of which Debian packages these are, and which of them every Linux of this kind has."""

import functools
import pathlib
import re
import subprocess

from .commands import Failure, output_of

# The C library, which comes with the system: it must fit the kernel, and loads modules of its own version.
OF_THE_SYSTEM = "libc6"
# oneTBB opens its allocator at run time, so that no program names it, and does without it where it is missing.
OPENED_AT_RUN_TIME = {"libtbb.so.12": ("libtbbmalloc.so.2",)}


@functools.cache
def system_libraries():
    """The names of the C library's files."""
    files = output_of("dpkg-query", "--listfiles", OF_THE_SYSTEM).splitlines()
    return frozenset(pathlib.Path(file).name for file in files if re.search(r"\.so(\.\d+)*$", file))


def packages_of(files):
    """The Debian packages that files belong to: {file: package}. The database has some paths as they were before /lib
    became a link to /usr/lib."""
    spellings = {}
    for file in files:
        for path in (str(file), str(pathlib.Path(file).resolve())):
            for spelling in (path, path.removeprefix("/usr"), f"/usr{path}"):
                spellings[spelling] = file
    # It fails if one of the spellings is unknown.
    said = subprocess.run(["dpkg-query", "--search", *spellings], capture_output=True, text=True, check=False).stdout
    found = {}
    for line in said.splitlines():
        owners, _, path = line.rpartition(": ")
        if path in spellings:
            found[spellings[path]] = owners.split(",")[0].split(":")[0]
    for file in files:
        if file not in found:
            raise Failure(f"{file} belongs to no Debian package, so that its licence is not known")
    return found


def loaded_by(program):
    """Where the loader finds the libraries of a program, and theirs: {name: path}."""
    found = {}
    for line in output_of("ldd", program).splitlines():
        words = line.split()
        if "not found" in line:
            raise Failure(f"{program} needs {words[0]}, which is not installed")
        if len(words) >= 3 and words[1] == "=>":
            found[words[0]] = pathlib.Path(words[2])
    return found


def bundled_by(programs):
    """The libraries that have to come with programs: {name: path}, without those of the system."""
    found = {}
    for program in programs:
        found.update(loaded_by(program))
    for opener, names in OPENED_AT_RUN_TIME.items():
        if opener not in found:
            continue
        for name in names:
            path = found[opener].with_name(name)
            if not path.exists():
                raise Failure(f"{opener} opens {name}, which is not installed beside it")
            found.update({name: path, **loaded_by(path)})
    return {name: path for name, path in sorted(found.items()) if name not in system_libraries()}


def dynamic_section(file):
    """What a file asks of the loader: the names of libraries, and where to look: {"RPATH" or "RUNPATH": path}."""
    text = output_of("readelf", "--dynamic", "--wide", file)
    return re.findall(r"\(NEEDED\).*\[(.*)\]", text), dict(re.findall(r"\((RPATH|RUNPATH)\).*\[(.*)\]", text))
