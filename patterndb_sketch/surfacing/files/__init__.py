"""The formats of network files, each a module: what a file's content says, without the file."""
