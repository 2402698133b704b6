"""Whether a folder of programs and libraries works without the libraries of this machine."""

import re

from .commands import Failure, output_of
from .libraries import dynamic_section, system_libraries

# From the programs in bin to their libraries. As an RPATH it holds for libraries' libraries too, and comes before
# LD_LIBRARY_PATH, in which other environments have other versions.
SEARCH_PATH = "$ORIGIN/../lib"


def check_files(folder):
    """Fails if a library is left out, or would be looked for elsewhere."""
    programs, libraries = sorted((folder / "bin").iterdir()), sorted((folder / "lib").iterdir())
    present = {library.name for library in libraries} | system_libraries()
    for file in (*programs, *libraries):
        needed, paths = dynamic_section(file)
        left_out = [name for name in needed if name not in present]
        if left_out:
            raise Failure(f"{file.name} needs {', '.join(left_out)}, which is left out")
        if paths != ({"RPATH": SEARCH_PATH} if file in programs else {}):
            raise Failure(f"{file.name} looks for libraries in {paths or 'the folders of the system'}, not the wheel's")
    for program in programs:
        check_loaded(program, folder / "lib")


def check_loaded(program, lib):
    """Fails if the loader takes a library that is not of the system from elsewhere."""
    for line in output_of("ldd", program).splitlines():
        match = re.match(r"\s*(\S+) => (\S+)", line)
        if match and match[1] not in system_libraries() and not match[2].startswith(f"{program.parent}/../{lib.name}/"):
            raise Failure(f"{program.name} loads {match[1]} from {match[2]}")


def check_versions(folder, version):
    """Fails if a program does not start, or is of another version than the wheel."""
    for program in sorted((folder / "bin").iterdir()):
        said = output_of(program, "--version").strip()
        if said != f"{program.name} {version}":
            raise Failure(f"{program.name} is {said!r}, and the wheel of version {version}: build both anew")
