"""Pytest plugin: load ``contact_toolkit._core`` from the file named by CONTACT_TOOLKIT_CORE.

`make sanitize` and `make tsan` build an instrumented core beside the installed one; this puts it
in the installed one's place without a second environment.
"""

import importlib.util
import os
import sys

_NAME = "contact_toolkit._core"
_PATH = os.environ["CONTACT_TOOLKIT_CORE"]

_spec = importlib.util.spec_from_file_location(_NAME, _PATH)
if _spec is None or _spec.loader is None:
    raise ImportError(f"{_PATH} is not an extension module")
_module = importlib.util.module_from_spec(_spec)
sys.modules[_NAME] = _module
_spec.loader.exec_module(_module)


def pytest_report_header() -> str:
    return f"{_NAME}: {_PATH}"
