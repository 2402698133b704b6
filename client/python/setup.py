"""The step that pyproject.toml cannot describe: descriptors and version are made when the package is built."""

import pathlib
import sys

from setuptools import setup
from setuptools.command.build_py import build_py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import build_package  # noqa: E402


class BuildWithDescriptors(build_py):
    def run(self):
        super().run()
        build_package.write_data(pathlib.Path(self.build_lib) / "sightline")


setup(version=build_package.version(), cmdclass={"build_py": BuildWithDescriptors})
