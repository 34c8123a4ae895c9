"""How Sphinx makes the site of what build_site.py has staged. Everything works from a folder of files, without a server and without the
network: no fonts, scripts or pictures of other machines."""
import os

from pygments.lexers.special import TextLexer

project = "hapticd"
author = "the hapticd authors"
copyright = "the hapticd authors"  # pylint: disable=redefined-builtin  # Sphinx asks for this name
version = release = os.environ["HAPTICD_VERSION"]

extensions = ["myst_parser", "breathe"]
breathe_projects = {"hapticd": os.environ["HAPTICD_DOXYGEN_XML"]}
breathe_default_project = "hapticd"
breathe_show_include = False
myst_heading_anchors = 4  # links to headings are named as GitHub names them
suppress_warnings = ["myst.header", "misc.highlighting_failure"]  # pages that begin with a smaller heading, and code that is none

html_theme = "furo"
html_title = f"hapticd {version}"
html_copy_source = False
html_show_sphinx = False
html_show_search_summary = False  # a page that was opened from a file may not fetch another
html_use_index = True
html_js_files = [("scripts/gumshoe-patched.js", {"priority": 190})]  # before the theme's own, which needs it; see build_site.py
html_theme_options = {"sidebar_hide_name": False}
pygments_style = "default"
highlight_language = "none"


def setup(app):
    """Names of code blocks that Pygments has no colours for."""
    for name in ("hex", "stop", "textproto"):
        app.add_lexer(name, TextLexer)
