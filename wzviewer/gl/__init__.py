"""The only package that calls OpenGL (3.3 core; 4.3 is used where there is one).

::

    scene ──sync──► arrivals        which levels are complete, chunk by chunk   (pages, merging: 2x2, 4x4)
                      │
    camera ───────► visible         chunks out of view or of weight 0 are skipped   (cull, sieve, stacks)
                      │ a selection: runs of surfels, and what Eq. 3 needs of each level
          ┌───────────┴─────────────────────────────┐
      a GPU                                     software OpenGL
          │                                         │
      order | compute | ordering                    │
          │ exact, nearest first: on the CPU,       │
          │ in GL 4.3 shaders, or off the thread    │
          ▼                                         ▼
      shading ──► draw                          software
          │ one draw, premultiplied "over",         │ kernels on the CPU: the same formulas
          │ points and quads, no depth test         │ and order, front to back in tiles
          │ shaders/surfel.vert [.geom] .frag       │
          └───────────┬─────────────────────────────┘
                      ▼
                    frame ──► present    composited over the background, into a window or into bytes
                      ├─────► median     the surfel at which transmittance crosses 0.5, per pixel
                      └─────► picking    the same for one pixel

    context     window | EGL | OSMesa             surfel_buffer, records   32 bytes a surfel on the GPU
    shader      files -> programs                 blocks                   a row of texels per level
    targets     textures that are drawn into      timing                   what the GPU takes
    blit        pictures in memory, copied        tiles                    pictures of any size
"""
