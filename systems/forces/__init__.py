"""How forces go along with steps: at the present (explicit), or solved with them (implicit)."""
