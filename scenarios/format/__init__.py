"""Scenario files: their schema, loading and errors."""
