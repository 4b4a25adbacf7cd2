"""The models behind the stages.

::

    base.py       Protocols, and the Synthesizer that bundles them
    registry.py   name ──► Synthesizer          catalogue.py  names, without importing a model
    builtin/      the default: no weights to download
"""
