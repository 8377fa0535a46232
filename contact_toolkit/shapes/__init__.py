"""Bodies: triangle meshes and their files, convex pieces, primitives."""
