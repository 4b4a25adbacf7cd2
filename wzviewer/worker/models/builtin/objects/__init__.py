"""Objects from a prompt, without weights: signed-distance bodies lit by the photograph.

::

    "a small red ladybug on the petal, wet with dew"
        │  grammar     words -> Edit (what, how many, how large, which colour, where; what weather)
        │   └ words    every word there is                   nouns     who builds which object
        ▼
    bodies ── insects, crawlers, butterflies, birds, wings, fishes, lizards, cats, molluscs,
        │  │      flowers, leaves, fungi, treasures, things   an object = flat arrays
        │  └ traits, sheets, baking            colours; outlines and veins -> 2-D distance textures
        │    substances                        the same body in gold, wood, stone, glass, moss
        ▼
    places       "on the sunflower" -> a spot in the picture, by its look
        │          sizes    natural sizes against metres a pixel, and what is still seen
    surfaces     where the depth steps: the front surface with room for it, and what lies behind its edge
        ▼
    placement    relief of the support -> pose (tilt, heading, size), contact
        │          footing  what stands goes to the nearest surface that faces up
        ▼
    render ── rays         tiles, threads; thin: hairs widened to a pixel, balls that hold thin parts
      ├────── march        ONE compiled interpreter of the arrays: rays -> hits; occlusion, shadows
      │         └ primitives   the distance functions, of plain `shapes` and of those that are swept
      ├────── patterns     materials: colour and relief that grow finer as the pixel shrinks
      │         └ chitin, skins, botany, minerals, terms, noise
      └────── dressing     what wears fur gets it: every hair drawn, at every level, by `furring`
                └ roots, hairs, coats, strands   where they are, their shape and light, their lie, kernels
        ▼
    shading      linear light: key, sky, bounce, coat     lighting   light read from the photograph
        ▼
    ground       what the body leaves of the light on its support; it ends before the level's `border`
        ▼
    composite    shadow on the real support, sharpness and grain of the background
        ▼
    peeling      what the view hides: the trunk behind limbs and wings, flanks from rays beside the view
        │          parts    wings over limbs over trunk over the ground, each with its coverage
        ▼
    inserting    all of it for one object     weather, dew   what covers the whole picture
        │                                     cutout, cards   an image file goes in by the same door
    deeper       the same object again at a deeper level; dew draws its drops again
    placed       what is kept of it

`editor.ObjectEditor` is the public face; everything else is private to this package.  The same
object is marched again at every deeper level (`ObjectEditor.continue_into`), so a zoom into a
ladybug shows punctures, then cells, then grain, and never blurred pixels.
"""
