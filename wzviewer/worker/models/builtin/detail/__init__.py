"""Detail from nothing but the picture: the built-in super-resolver and describer (Sec. 3.2, U and S).

::

    image ──► describe ──► Context (label map, materials, words)
                              │
    observation L ─┬─► crisp ─┼─► contours, sharp, no halos ─┐
                   │          ▼                              ▼
                   ├─► texture (tiles, flow) ─► amplitude ─► sum ─► consistency ─► Detail
                   │     what a material      how strong            shrunk, it
                   │     looks like closer    it may be             is L again
                   └──────────────────────────────────────────────────▲

`quiet` takes a photograph's noise out before.  `crisp` is a compact network of our own; `contours` makes
steep what is faint, in metal and beyond the photograph.  What larger forms the coarser picture may have
missed, `drifts` knows for air and water.  What is laid on it is material, never objects, letters or faces,
and only where the picture itself is textured.
"""
