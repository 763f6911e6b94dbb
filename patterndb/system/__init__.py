"""What touches the machine: caches (the user's folder), mappedarrays (arrays kept there), files,
documents (JSON), kernels (compiled code and where it is kept), and readers of formats that are no
one tool's own."""
