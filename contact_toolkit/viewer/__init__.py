"""Shapes and queries in the browser, without a simulator."""

from contact_toolkit.viewer.viewer import Viewer

__all__ = ["Viewer"]
