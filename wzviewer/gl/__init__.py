"""The only package that calls OpenGL (3.3 core).

::

    scene ──sync──► surfel_buffer   32-byte records in pages, appended once      (records: the layout)
                      │
    camera ─┬─► blocks              a row of texels per level: camera, parent, covers
            ├─► visible             the CPU side of a frame, no OpenGL:
            │     ├── cull            chunks outside the frustum or of weight 0 are skipped
            │     └── order           exact back-to-front order of what is left
            │
            └─► renderer ──► draw   one draw (points, or quads), premultiplied "over", no depth test
                  │   shaders/surfel.vert [.geom] .frag  +  include/{anchor,opacity,footprint}.glsl
                  ▼
                frame ──► present   composited over the background, into a window or for reading
                  ├─────► median    rank of the surfel at which transmittance crosses 0.5
                  └─────► picking   the same for one pixel, on the CPU

    context     window | EGL | OSMesa
    shader      files -> programs, errors as file:line
    targets     textures that are drawn into
"""
