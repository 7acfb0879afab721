"""The version of the installed package, which the build takes from the last tag."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("pymdr")
except PackageNotFoundError:  # the source is on the path without an installation
    __version__ = "0+unknown"
