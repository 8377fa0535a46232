"""The contact law, friction, and the model that turns poses and velocities into wrenches."""
