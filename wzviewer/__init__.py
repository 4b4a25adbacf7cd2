"""wzviewer: one photograph becomes a 3D world that you can zoom into without end.

::

    cli ──► app (Thread 1: the frame loop) ──► gl + shaders     draws E_0 .. E_n
              │        ▲
              │        │ typed messages, shared memory
              ▼        │
            worker (Thread 2: Algorithm 1, lines 10-32) ──►  appends E_{i+1}

            core: what the paper defines, in numpy; everybody imports it
"""

__version__ = "0.1.0"
