"""The same scenario under ours, Drake's and MuJoCo's contact, side by side."""
