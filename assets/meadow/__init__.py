"""The bundled picture's scene, from noise to light.

noise -> ground -> sheets -> flowers, woods -> planting      the triangles
|
visibility (camera, sun) -> light <- sky      the picture
"""
