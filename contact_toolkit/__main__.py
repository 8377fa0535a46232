"""`python -m contact_toolkit`: the command line, `contact-toolkit`."""

from contact_toolkit.companions import import_companion

import_companion("scenarios.cli").app(prog_name="python -m contact_toolkit")
