"""What touches the machine: files, documents, the user's cache folder, compiled kernels."""
