"""How the lines, marks and letters of a drawing look, on a page and in a file of its own."""

from __future__ import annotations

STYLE = """
.fig{font-family:var(--sans,system-ui,sans-serif);font-size:12px;fill:var(--ink,#22262b)}
.fig .axis{stroke:var(--ink,#22262b);stroke-width:1;fill:none;stroke-linecap:square}
.fig .grid{stroke:var(--rule,#d9d5cc);stroke-width:.8;fill:none}
.fig .tick{font-size:11px;fill:var(--soft,#666b72)}
.fig .name{font-size:13.5px}
.fig .name .it{font-style:italic;font-family:var(--serif,Georgia,serif)}
.fig .curve{stroke:var(--ink,#22262b);stroke-width:1.7;fill:none;stroke-linejoin:round}
.fig .level{stroke:var(--blue,#2f5f8f);stroke-width:1.05;fill:none;stroke-linejoin:round}
.fig .edge{stroke:var(--blue,#2f5f8f);stroke-width:1.1;fill:none;stroke-dasharray:5 4}
.fig .energy{stroke:var(--soft,#666b72);stroke-width:1;fill:none;stroke-dasharray:2 3}
.fig .motion{stroke:var(--red,#b8402a);stroke-width:2;fill:none;stroke-linejoin:round;stroke-linecap:round}
.fig .faint{stroke:var(--red,#b8402a);stroke-width:1.1;fill:none;opacity:.4;stroke-linejoin:round}
.fig .area{fill:var(--red,#b8402a);opacity:.11;stroke:none}
.fig .region{fill:var(--blue,#2f5f8f);opacity:.08;stroke:none}
.fig .dot{fill:var(--red,#b8402a);stroke:var(--paper,#fffdf8);stroke-width:1.6}
.fig .ring{fill:var(--paper,#fffdf8);stroke:var(--red,#b8402a);stroke-width:1.8}
.fig .centre{fill:var(--ink,#22262b)}
.fig .note{font-size:11.5px;fill:var(--soft,#666b72)}
.fig .warm{fill:var(--red,#b8402a)}
.fig .proof{stroke:var(--red,#b8402a);stroke-width:1.5;fill:none;stroke-dasharray:5 4}
.fig .redmark{fill:var(--red,#b8402a);stroke:var(--red,#b8402a);stroke-width:1.3}
.fig .bluemark{fill:var(--blue,#2f5f8f);stroke:var(--blue,#2f5f8f);stroke-width:1.3}
.fig .inkmark{fill:var(--ink,#22262b);stroke:var(--ink,#22262b);stroke-width:1.3}
.fig .hollow{fill:var(--paper,#fffdf8)}
.fig .cross{fill:none;stroke-width:1.7}
.fig .cool{fill:var(--blue,#2f5f8f)}
"""
"""Colours are the page's variables, with defaults for a drawing that stands alone."""


def standalone(svg: str) -> str:
    """Make a drawing a file of its own, which follows the reader's light or dark page.

    Args:
        svg: an element made by ``assemble``.

    Returns:
        The element with its style inside.
    """
    dark = (
        "@media (prefers-color-scheme:dark){svg{--ink:#e6e3dc;--soft:#a2a6ad;--rule:#3b4048;--blue:#7fb2e5;"
        "--red:#f0846b;"
        "--paper:#16191d}}"
    )
    head, _, rest = svg.partition(">")
    return f"{head}><style>{STYLE}{dark}</style>{rest}\n"
