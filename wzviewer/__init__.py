"""wzviewer: one photograph becomes a 3D world that you can zoom into without end.

::

    cli ──► app (Thread 1: the frame loop) ──► gl + shaders     draws E_0 .. E_n
              │        ▲
              │        │ typed messages, shared memory
              ▼        │
            worker (Thread 2: Algorithm 1, lines 10-32) ──►  appends E_{i+1}

            core: what the paper defines, in numpy; everybody imports it
            kernels: compiled loops over surfels, for the worker and for software GL
"""

__version__ = "0.1.0"

__all__ = ["Renderer", "Scene", "__version__", "generate"]


def __getattr__(name: str) -> object:
    # Imported on first use, so that `import wzviewer` and `wzviewer --help` are instant.
    if name in ("generate", "Renderer"):
        from wzviewer import api

        return getattr(api, name)
    if name == "Scene":
        from wzviewer.core.scene import Scene

        return Scene
    raise AttributeError(f"module 'wzviewer' has no attribute {name!r}")
