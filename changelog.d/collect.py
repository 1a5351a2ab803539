"""Move the fragments of this folder into ``CHANGELOG.md``: ``python changelog.d/collect.py 0.2.0``.

``tests/docs/test_changelog.py`` checks every fragment with ``faults``.
"""

from __future__ import annotations

import datetime as dt
import sys
from collections.abc import Mapping
from pathlib import Path

HERE = Path(__file__).resolve().parent
KINDS = {"added": "Added", "changed": "Changed", "fixed": "Fixed", "removed": "Removed"}
MOVED = "moved"
TABLE = "### Numbers that moved\n\n| what | before | now | why |\n|---|---|---|---|\n"
NOTHING = "| – | – | – | no result moved |\n"
LINES = 3


def fragments(folder: Path) -> dict[str, str]:
    """Return the text of every fragment, by the name of its file, in order."""
    found = sorted(path for path in folder.glob("*.md") if path.name != "README.md")
    return {path.name: path.read_text(encoding="utf-8").strip() for path in found}


def faults(texts: Mapping[str, str]) -> list[str]:
    """Return what is wrong with some fragments, one line each."""
    found = []
    for name, text in texts.items():
        kind = name.split(".")[-2] if name.count(".") == 2 else ""
        lines = text.splitlines()
        if kind not in (*KINDS, MOVED):
            found.append(f"{name}: the name must end in .added.md, .changed.md, .fixed.md, .removed.md or .moved.md")
        elif kind == MOVED and any(line.count(" | ") != 3 for line in lines):
            found.append(f"{name}: each line must be a row of four cells, | what | before | now | why |")
        elif text.startswith("- "):
            found.append(f"{name}: leave out the bullet before it; one is put there")
        elif not text or (kind != MOVED and len(lines) > LINES):
            found.append(f"{name}: one to {LINES} lines are needed, not {len(lines)}")
    return found


def section(version: str, day: dt.date, texts: Mapping[str, str]) -> str:
    """Return the section of a release: what was added, changed, fixed and removed, and the numbers that moved."""
    parts = [f"## {version} ({day.isoformat()})\n"]
    for kind, title in KINDS.items():
        own = [text for name, text in texts.items() if name.endswith(f".{kind}.md")]
        if own:
            parts.append(f"### {title}\n\n" + "\n".join("- " + text.replace("\n", "\n  ") for text in own) + "\n")
    rows = "".join(f"{text}\n" for name, text in texts.items() if name.endswith(f".{MOVED}.md"))
    parts.append(TABLE + (rows or NOTHING))
    return "\n".join(parts) + "\n"


def merged(changelog: str, new: str) -> str:
    """Return the changelog with a new section above the others."""
    head, mark, rest = changelog.partition("\n## ")
    return head + "\n" + new + mark.lstrip("\n") + rest


def main(version: str) -> None:
    """Write the section of a release and delete its fragments; nothing is written where one is faulty."""
    texts, target = fragments(HERE), HERE.parent / "CHANGELOG.md"
    if wrong := faults(texts):
        raise SystemExit("\n".join(wrong))
    new = section(version, dt.datetime.now(dt.UTC).date(), texts)
    target.write_text(merged(target.read_text(encoding="utf-8"), new), encoding="utf-8")
    for name in texts:
        (HERE / name).unlink()


if __name__ == "__main__":
    main(*sys.argv[1:])
