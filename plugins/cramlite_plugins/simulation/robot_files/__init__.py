"""Old names of modules of `cramlite_plugins.imports.robots`."""
