//! Enumeration of the patches of quad meshes.
