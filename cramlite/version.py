"""The version of cramlite, for those modules that the package itself leads to."""

VERSION = "0.1.0"
