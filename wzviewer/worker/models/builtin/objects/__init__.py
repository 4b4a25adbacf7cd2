"""Objects from a prompt, without weights: signed-distance bodies lit by the photograph.

::

    "a small red ladybug on the petal"
        │  grammar     words -> Edit (what, how many, how large, which colour, where)
        ▼
    bodies ── insects, butterflies, things     an object = flat arrays of primitives and materials
        │        └ baking                      outlines and veins -> 2-D distance textures
        ▼
    placement    relief of the support -> pose (tilt, heading, size), contact
        ▼
    render ── march        ONE compiled interpreter of the arrays: rays -> hits; occlusion, shadows
      │         └ primitives   the distance functions
      └────── patterns     materials: colour and relief that grow finer as the pixel shrinks
                └ chitin, terms, noise
        ▼
    shading      linear light: key, sky, bounce, coat     lighting   light read from the photograph
        ▼
    composite    shadow on the real support, sharpness and grain of the background
        ▼
    inserting    all of it for one object     cutout   an image file goes in by the same door
    deeper       the same object again at a deeper level
    placed       what is kept of it

`editor.ObjectEditor` is the public face; everything else is private to this package.  The same
object is marched again at every deeper level (`ObjectEditor.continue_into`), so a zoom into a
ladybug shows punctures, then cells, then grain, and never blurred pixels.
"""
