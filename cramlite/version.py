"""The version of cramlite, in a module of its own, which every module can import without a cycle."""

VERSION = "0.1.0"
