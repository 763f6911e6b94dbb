"""The parts of files: curve networks, templates and shape models as JSON and arrays."""
