"""Settings of the site: `make docs`. What is generated is in `extensions`."""

import os
import sys
from datetime import date
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))

import celltrain  # noqa: E402

project = "celltrain"
author = "the celltrain developers"
copyright = f"{date.today().year}, {author}"
release = version = celltrain.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "docstrings",
    "formulas",
    "generated",
    "links",
]
exclude_patterns = [
    "_site",
    "jupyter_execute",
    "extensions",
    "requirements.lock",
    "validation/data",
    "tutorials/run",
]

# Every page is Markdown that a code host shows, too.
myst_enable_extensions = ["amsmath", "colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

# Pages with code cells are run each time; a cell that fails fails the build.
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True
# Commands of the tutorials are those of this environment, and their tables are not broken.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
os.environ["CELLTRAIN_DOCS"] = str(HERE)
os.environ.update(COLUMNS="80", NO_COLOR="1", TERM="dumb", PYDEVD_DISABLE_FILE_VALIDATION="1")

html_math_renderer = "mathml"
math_number_all = False
math_eqref_format = "({number})"

autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": False}
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
default_role = "code"

# Which of two modules' types of one name a signature means is not said there.
suppress_warnings = ["ref.python"]
# Types of other libraries have no page here, and none is fetched.
nitpicky = True
nitpick_ignore_regex = [("py:.*", r".*")]

html_theme = "furo"
html_title = f"celltrain {version}"
html_static_path: list[str] = []
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
