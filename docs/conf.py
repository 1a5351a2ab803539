"""The documentation site: ``python -m sphinx -W --keep-going docs site`` (extra ``docs``).

The pages are the Markdown files of this folder, which read well without the site too. Written while it is built: the
gallery, with a report of every catalog entry (``gallery.py``), and the results of the notebooks.
"""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import gallery  # noqa: E402  (a file next to this one)
from sphinx.application import Sphinx  # noqa: E402

import hjsolve  # noqa: E402

project, author, copyright = "hjsolve", "the authors of hjsolve", "the authors of hjsolve"  # noqa: A001
release = version = hjsolve.__version__
extensions = [
    "myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode", "sphinx_copybutton", "sphinx_design",
    "site_extensions",
]  # fmt: skip
exclude_patterns = ["_generated/reports", "**.ipynb_checkpoints"]
html_math_renderer = "mathml"  # no mathematics by a script from the net
numfig = False
math_eqref_format = "({number})"

html_theme = "furo"
html_title = f"hjsolve {release}"
html_static_path = ["static"]
html_css_files = ["hjsolve.css"]
html_extra_path = ["_generated/site"]
html_show_sphinx = False
pygments_style, pygments_dark_style = "friendly", "native"

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_dmath_double_inline = False
myst_heading_anchors = 4
myst_url_schemes = ["http", "https", "mailto"]
nb_execution_mode = "cache"
nb_execution_timeout = 120
nb_execution_raise_on_error = True
nb_merge_streams = True
suppress_warnings = ["mystnb.unknown_mime_type"]

autodoc_member_order = "bysource"
autodoc_mock_imports = ["jax"]  # the site is built without it
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_class_signature = "separated"
python_use_unqualified_type_names = True
autodoc_preserve_defaults = True
nitpicky = True  # every reference leads somewhere; types of other packages are words, since a build fetches nothing
nitpick_ignore_regex = [
    ("py:.*", r"(sympy|sp|mpmath|numpy|np|pathlib|collections|matplotlib|importlib|os|flint|astropy|dask)\..*"),
    ("py:.*", r"Axes|FuncAnimation|NDArray|Path|Array|Reals|Numbers|Vector|Window|Quantity|Toml|Times|Numeric|Mpf"),
    ("py:exc", "ArgumentIndexError"),  # of sympy's own docstrings
    ("py:class", r"hjsolve\..*\.[A-Z]"),  # type variables
    # protocols of numbers, texts of captions, and what only hjsolve itself reads of a result
    ("py:class", r"hjsolve\.(arithmetic\..*|reports\.document\.blocks|one_coordinate\..*)\.\w+"),
    ("py:class", r"hjsolve\.(scenes\.(question|resting_contact|events)|ensembles\.orbit_columns)\.\w+"),
    ("py:class", r"hjsolve\.(motion\.in_units|extended\.(quadratic_flow|ends_of_domains))\.\w+"),
    ("py:class", r"hjsolve\.(scenes\.results\.Choice|mechanics\.quantities_given\.Measures)"),
]
napoleon_google_docstring, napoleon_numpy_docstring = True, False
napoleon_use_ivar = True


def setup(app: Sphinx) -> None:
    """Write the gallery first; links to files next to this folder lead to their pages.

    Args:
        app: what builds the site.
    """
    gallery.write(HERE / "_generated")
    app.connect("source-read", _inside)


def _inside(_app: Sphinx, _name: str, source: list[str]) -> None:
    source[0] = source[0].replace("(../catalog/README.md)", "(_generated/catalog.md)")
