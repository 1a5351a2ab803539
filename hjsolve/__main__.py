"""``python -m hjsolve``: the command line."""

from hjsolve.command_line.main import main

raise SystemExit(main())
