"""How the site is made: `make docs`, which puts notebooks and benchmarks beside these pages."""

import shutil
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))

project = "Contact Toolkit"
author = "Contact Toolkit authors"
copyright = "Contact Toolkit authors, BSD-3-Clause"  # noqa: A001  Sphinx's name
version = release = installed_version("contact-toolkit")

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "sphinx_design",
    "mathml",
    "scenario_gallery",
]
templates_path = ["_templates"]
# Notebooks stand beside their scripts; benchmarks hold more than what is read.
exclude_patterns = ["notebooks/figures/README.md", "notebooks/*.py", "**/runs/**"]

# Markdown and notebooks
myst_enable_extensions = ["amsmath", "attrs_inline", "colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 900  # [s] a cell
nb_merge_streams = True

# The reference: what is in `__all__`, a page a name.
autosummary_generate = True
autosummary_ignore_module_all = False
autosummary_imported_members = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc's sections tell shapes and units, the signatures types
numpydoc_show_class_members = False
default_role = "py:obj"
suppress_warnings = ["ref.python"]  # a plain word in backticks may be the name of two methods

html_theme = "furo"
html_title = "Contact Toolkit"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False


def _copy_playbacks(app: object, exception: Exception | None) -> None:
    """Put the playbacks that notebooks show inline beside their pages."""
    if exception is None and (runs := HERE / "notebooks" / "runs").is_dir():
        target = Path(app.outdir) / "notebooks" / "runs"
        target.mkdir(parents=True, exist_ok=True)
        for page in runs.glob("*.html"):
            shutil.copy(page, target)


def setup(app: object) -> None:
    """Connect to Sphinx."""
    app.connect("build-finished", _copy_playbacks)
