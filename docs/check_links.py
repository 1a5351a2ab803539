"""Follow every link inside the built site: ``python docs/check_links.py site``; status 1 where one leads nowhere."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """Links and anchors of a page."""

    def __init__(self, text: str):
        super().__init__()
        self.links: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:  # noqa: ARG002
        """Keep what is linked and what can be linked to.

        Args:
            tag, attrs: of an element.
        """
        values = {name: value for name, value in attrs if value}
        self.anchors.update(values[name] for name in ("id", "name") if name in values)
        self.links.update(values[name] for name in ("href", "src") if name in values)


def broken(root: Path) -> list[str]:
    """Links of all pages that lead nowhere.

    Args:
        root: folder of the site.
    """
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in root.rglob("*.html")}
    found = []
    for path, page in pages.items():
        for link in sorted(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            # viewcode keeps one name of a module for its links back, where a page has public and inner names of it
            back = path.relative_to(root.resolve()).parts[0] == "_modules"
            lost = not target.exists() or (
                parts.fragment and not back and target in pages
                and unquote(parts.fragment) not in pages[target].anchors
            )  # fmt: skip
            if lost:
                found.append(f"{path.relative_to(root.resolve())}: {link}")
    return found


def main() -> None:
    """Tell what is broken."""
    lost = broken(Path(sys.argv[1]))
    print("\n".join(lost) or "every link inside the site leads somewhere")
    sys.exit(bool(lost))


if __name__ == "__main__":
    main()
