"""Thread 2 of Algorithm 1, in its own process: the progressive detail synthesizer.

::

    app (client.py)                          worker (process.py)
      │ ── SynthesizeLevel(C_{i+1}, U) ──────► │  synthesis.py, lines 10-32
      │ ◄───────────────────── LevelBegun ──── │  stage 1  new scale image
      │ ◄──────── SurfelsAppended* (preview) ─ │  stage 2  depth registration
      │        … frames go on …                │  stage 3  surfels
      │ ◄─────────────────── StageStarted* ─── │  stage 4  auxiliary views
      │ ◄──────── SurfelsReplaced* (refined) ─ │  stage 5  optimisation
      │ ◄───────────────── LevelCommitted ──── │
      │ ── Cancel ───────────────────────────► │  ──► LevelAborted within a second, or the
      │                                        │      process is killed and started again

Small messages go through a pipe; arrays through shared-memory slots that the app owns, against
credits, so that neither side can flood the other (transport.py).
"""
