"""Systems that observe contact: swept checks and pictures."""
