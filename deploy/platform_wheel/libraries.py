"""Which libraries programs need, of which Debian packages these are, and which of them every Linux of this kind has."""

import functools
import pathlib
import re

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


def package_of(file):
    """The Debian package that a file belongs to. The database has paths as they were before /lib became a link to /usr/lib."""
    spellings = dict.fromkeys(str(path) for path in (pathlib.Path(file), pathlib.Path(file).resolve()))
    for path in [spelling for path in spellings for spelling in (path, path.removeprefix("/usr"), f"/usr{path}")]:
        try:
            return output_of("dpkg-query", "--search", path).split(":", 1)[0]
        except Failure:
            continue
    raise Failure(f"{file} belongs to no Debian package, so that its licence is not known")


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


def needed(file):
    """The names of the libraries that a file asks the loader for."""
    return re.findall(r"\(NEEDED\).*\[(.*)\]", output_of("readelf", "--dynamic", "--wide", file))


def search_paths(file):
    """Where a file makes the loader look: {"RPATH" or "RUNPATH": path}."""
    return dict(re.findall(r"\((RPATH|RUNPATH)\).*\[(.*)\]", output_of("readelf", "--dynamic", "--wide", file)))
