"""What the photograph does not show: Algorithm 1, lines 26-28, without network weights.

::

    image, relief, sky                                       source camera C
          │
       edges        depth steps made sharp, the mixed-colour fringe given to the near side
          │
       outpaint     level 0 only: the frame is padded, so that an orbit does not meet its border
          │
       fronts ──► background ──► exemplar     one layer behind every depth edge, painted with
          │             ▲                     patches of the picture at the layer's own depth
          │             └── repeated: each layer lies behind the one before
       thinning     only what some neighbouring camera can see is kept
          │
      leftovers     what eight neighbouring cameras still miss
          │
      backdrop      level 0 only: smooth and coarse, behind and beside everything
          │
      hidden_sky    level 0 only: the colours of all hidden sky, from one smooth field
          │
       synthesizer.Completion      front relief, layers: one definition of the hidden world
          │
       mesh         exact renders of it from neighbouring cameras, the I_k of line 28

Everything is decided once, in the source view, so all neighbouring views agree by construction.
Depth is measured along `axis.DepthAxis`, in px of image shift per unit of tan(orbit angle).
"""
