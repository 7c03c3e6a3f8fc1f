//! Indexed meshes: adjacency, readers, writers and built-in shapes.
