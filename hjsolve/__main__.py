"""``python -m hjsolve``: the command line."""

from hjsolve.cli import main

raise SystemExit(main())
