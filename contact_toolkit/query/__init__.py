"""Distance queries between two bodies at a relative pose or over a motion."""
