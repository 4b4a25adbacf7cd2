"""What the WonderZoom paper defines, in numpy: no OpenGL, no torch.

::

    camera ─ navigation           C, zoom about a pixel, orbit, fly       (float64)
       │
    opacity                       Eq. 1-3 on a tree, with coverage        (twin: include/opacity.glsl)
       │
    surfels ─ lift                g = {p, q, s, o, c, s_native}           (float32, level-local)
       │
    scene ─ foreground            the append-only log of levels E_0..E_n; what a view turns about
       └─── beside                which levels a new one will lie over
       │
    reference   messages   files  render by definition / wire / disk
"""
