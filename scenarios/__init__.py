"""Scenarios: YAML in, simulation, acceptance check, report; and the command line."""
