"""One module for each command line verb; nothing here is imported before its verb is asked for.

::

    cli.py ──► open  demo  generate  render  info  bench  models
                 │     │      │        │             │
                 ▼     └──────┴──► generation        └──► worker, gl
                app        (client ─► levels)   rendering (scene ─► pictures, films)
"""
