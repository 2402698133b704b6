"""The steps that pyproject.toml cannot describe: descriptors and version, and what a source archive needs to make them."""

import pathlib
import sys

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import build_package  # noqa: E402


class BuildWithDescriptors(build_py):
    def run(self):
        super().run()
        build_package.write_data(pathlib.Path(self.build_lib) / "sightline")


class ArchiveWithProtocol(sdist):
    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        build_package.copy_sources(pathlib.Path(base_dir))


setup(version=build_package.version(), cmdclass={"build_py": BuildWithDescriptors, "sdist": ArchiveWithProtocol})
