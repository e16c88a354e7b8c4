"""What pyproject.toml cannot say: main.pl, which belongs to no package, is installed beside the packages."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildWithMain(build_py):
    """Copy the packages, then main.pl, into an empty folder: nothing of an older build is installed."""

    def run(self) -> None:
        if not self.editable_mode:
            shutil.rmtree(self.build_lib, ignore_errors=True)
        super().run()
        if not self.editable_mode:
            self.copy_file("main.pl", str(Path(self.build_lib) / "main.pl"))

    def get_source_files(self) -> list[str]:
        return [*super().get_source_files(), "main.pl"]

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:
        return [*super().get_outputs(include_bytecode), str(Path(self.build_lib) / "main.pl")]


setup(cmdclass={"build_py": BuildWithMain})
