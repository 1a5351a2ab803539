"""The explorer: a page on this machine where a system is typed, judged and set in motion by the real engine.

In: a catalog id, a scene, or nothing. Out: a web page at 127.0.0.1 (extra ``explore``), until it is stopped.
Read ``answering.py`` first (a question in, an answer out), then ``worker.py`` (the process that answers, with limits on
its time and memory) and ``page.py`` (what is seen).
"""
