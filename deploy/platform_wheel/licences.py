"""The licences of what a wheel holds, from the Debian packages that it was taken from."""

import pathlib
import re
import shutil

from .commands import Failure, output_of
from .libraries import packages_of

DOCUMENTS = pathlib.Path("/usr/share/doc")
COMMON = pathlib.Path("/usr/share/common-licenses")
# Libraries that are headers only have become part of the programs.
HEADERS = ("/usr/include/CLI/CLI.hpp", "/usr/include/nlohmann/json.hpp", "/usr/include/boost/version.hpp")


def write_licences(libraries, folder):
    """Writes folder/PACKAGE/copyright for each package, the common licences that these name, and packages.csv: which
    version of which package each library is of. libraries: {name: path}."""
    packages = packages_of([*libraries.values(), *HEADERS])
    of_package = {packages[header]: [] for header in HEADERS}
    for name, path in libraries.items():
        of_package.setdefault(packages[path], []).append(name)

    common = set()
    rows = ["package,version,source,source_version,libraries"]
    for package, names in sorted(of_package.items()):
        text = DOCUMENTS / package / "copyright"
        if not text.is_file():
            raise Failure(f"{text} is not there: without its licence {package} cannot be passed on")
        (folder / package).mkdir(parents=True)
        shutil.copyfile(text, folder / package / "copyright")
        common |= set(re.findall(rf"{COMMON}/([A-Za-z]+(?:-[0-9]+(?:\.[0-9]+)?)?)", text.read_text(errors="replace")))
        fields = "${Version},${source:Package},${source:Version}"
        versions = output_of("dpkg-query", "--show", f"--showformat={fields}\n", package).splitlines()[0]
        rows.append(f"{package},{versions},{' '.join(names)}")
    (folder / "common").mkdir()
    for name in sorted(common):
        if (COMMON / name).is_file():
            shutil.copyfile(COMMON / name, folder / "common" / name)
    (folder / "packages.csv").write_text("\n".join(rows) + "\n")
