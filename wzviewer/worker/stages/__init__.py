"""The stages of Algorithm 1, with the paper's numbers.

::

    stage0_initial_scene        line 1        photo ─► depth, sky
    stage1_new_scale_image      lines 11-19   render ─► describe ─► super-resolve ─► edit
    stage2_depth_registration   lines 20-22   target depth ─► closed form ─► Eq. 5 ─► segments ─► holes
    stage3_surfel_generation    lines 23-25   image + depth ─► pixel-aligned surfels
    stage4_auxiliary_views      lines 26-28   background behind depth edges, outside the frame
    stage5_optimization         lines 29-31   Adam on q, s, o; 0.8 L1 + 0.2 D-SSIM
"""
