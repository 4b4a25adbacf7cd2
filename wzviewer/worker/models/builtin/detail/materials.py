"""The materials: what each is called, how rough it is, and what it is made of eight times closer.

::

    petal ──► velvet ─────┐                                       bark, straw ──┬──► yarn ◄── weave
    foliage ──► venation ─┴► tissue ► cell ──► granule ───┐                     └──► fibre ──► fibril
                     floret ─┘                            │         fur ──► hair ────────────────┤
    wet ► tear, skin, scales ► cornea ──┬──► cytoplasm ───┴► membrane ──► molecule ◄─────────────┘
                                                                              └──► helix ──► atom ──┐
    sand ──► rock ► stone ───┐                                                                      │
    paint ─────► bristle ────┼► granite ► facet ──► salt ──► shell ──┐                              │
    plaster ───► grit ───────┘                                       │                              │
    smooth ──► glaze ──► polish ──┬► alloy ──► lattice ──► sea ──────┴─► nucleus ◄── orbital ◄──────┤
    metal ──► cast, brushed ──────┘                                         └──► strings ──► froth  │
    sky, blur ► air ──► haze ► droplet ► frost ──────┐                                              │
    ripple ──► caustic ──► plankton ──► jelly ───────┴► ice ──► dipole ─────────────────────────────┘

Eight levels of x8 lead from a leaf to its atoms and into them.
"""

from dataclasses import dataclass

import numpy as np

from wzviewer.core.types import FloatArray


@dataclass(frozen=True, kw_only=True)
class Material:
    """One material.

    Attributes:
        name: its key; also the name of its tile (`tiles`) or grain (`flow`).
        word: what a person calls it.
        closer: name of what is seen after an enlargement by eight.
        gain: factor on the amplitude law.
        floor: least contrast of the new detail as a share of the luminance, at level 1.
        deep_floor: the same at level 2 and deeper; keeps long zooms from turning into mush.
        roughness_px: how far contours are displaced.
        ceiling: no detail of it is stronger than this RMS, in grey levels.
        between: name of what fills the dark lines that are seen where this material is: walls, gaps, seams;
            empty if it is the same.
        micro: least contrast at level 1 where the photograph is in focus, also if it shows none of it: no
            petal is as bare as it is from afar.
    """

    name: str
    word: str
    closer: str
    gain: float
    floor: float
    deep_floor: float
    roughness_px: float
    ceiling: float
    between: str = ""
    micro: float


def _material(
    name: str,
    word: str,
    closer: str,
    gain: float = 1.0,
    floor: float = 0.012,
    deep_floor: float = 0.022,
    roughness_px: float = 0.5,
    ceiling: float = 15.0,
    between: str = "",
    micro: float = 0.0,
) -> Material:
    return Material(
        name=name,
        word=word,
        closer=closer,
        gain=gain,
        floor=floor,
        deep_floor=deep_floor,
        roughness_px=roughness_px,
        ceiling=ceiling,
        between=between,
        micro=micro,
    )


DEEP = 0.14
"""Least contrast of what no eye sees, as a share of the luminance: micrographs have that and more."""

MATERIALS: dict[str, Material] = {
    material.name: material
    for material in (
        _material("smooth", "smooth surface", "glaze", 0.35, 0.004, 0.004, 0),
        _material("glaze", "glazed surface", "polish", 0.5, 0.004, 0.015, 0),
        _material("polish", "polished surface", "alloy", 0.5, 0.004, 0.05, 0),
        _material("metal", "metal", "cast", 0.35, 0.004, 0.004, 0, micro=0.014),
        _material("cast", "cast metal", "alloy", 0.5, 0.006, 0.04, 0.1),
        _material("alloy", "grains of crystal", "lattice", 0.7, 0.008, 0.1, 0.3),
        _material("wet", "wet gloss", "tear", 0.35, 0.004, 0.004, 0),
        _material("tear", "film of water", "cornea", 0.35, 0.004, 0.008, 0),
        _material("cornea", "smooth tissue", "cytoplasm", 0.5, 0.004, 0.065, 0.2),
        _material("sky", "smooth sky", "air", 0.15, 0.002, 0.002, 0),
        _material("blur", "soft background", "air", 0.15, 0.002, 0.002, 0),
        _material("air", "air", "haze", 0.15, 0.002, 0.005, 0),
        _material("haze", "haze", "droplet", 0.5, 0.004, 0.018, 0),
        _material("droplet", "droplets of mist", "frost", 0.7, 0.008, 0.085, 0),
        _material("frost", "crystals of ice", "ice", 0.7, 0.012, 0.12, 0.2),
        _material("foliage", "leaves", "venation", 2.8, 0.05, 0.05, 1.8, 28.0),
        _material("venation", "petal or leaf tissue", "tissue", 0.9, 0.01, 0.11, 0.3, micro=0.02),
        _material("bristle", "marks of a brush", "granite", 0.9, 0.012, 0.05, 0.2),
        _material("paint", "brush strokes", "bristle", 1.15, 0.016, 0.05, 0.4, micro=0.02),
        _material("floret", "florets", "tissue", 0.9, 0.012, 0.07, 0.3, micro=0.055),
        _material("petal", "petals", "velvet", 0.9, 0.01, 0.07, 0.2, micro=0.016),
        _material("velvet", "velvet of a petal", "tissue", 0.9, 0.012, 0.06, 0.4),
        _material("cell", "cells", "granule", 0.75, 0.012, DEEP, 1.2, 26.0),
        _material("granule", "grains of a cell", "membrane", 0.9, 0.012, DEEP, 1.2, 26.0, between="fibril"),
        _material("fibre", "fibres", "fibril", 1.0, 0.012, 0.08, 0.48),
        _material("hair", "hairs", "fibril", 0.9, 0.012, 0.05, 0.2),
        _material("fur", "fur", "hair", 0.9, 0.014, 0.05, 0.6),
        _material("straw", "stalks", "fibre", 1.1, 0.014, 0.05, 0.84),
        _material("bark", "bark", "fibre", 1.1, 0.016, 0.05, 1.1),
        _material("brushed", "brushed metal", "alloy", 0.6, 0.008, 0.018, 0.12),
        _material("rock", "rock", "stone", 1.2, 0.016, 0.09, 1.2),
        _material("stone", "weathered stone", "granite", 1.0, 0.014, 0.13, 0.8, 26.0),
        _material("granite", "crystals", "facet", 1.0, 0.014, DEEP, 0.84, 26.0),
        _material("sand", "gravel", "rock", 1.2, 0.016, 0.07, 0.96),
        _material("skin", "skin or leather", "cornea", 0.8, 0.008, 0.04, 0.24, micro=0.01),
        _material("plaster", "painted wall", "grit", 0.6, 0.006, 0.026, 0.1),
        _material("ripple", "water", "caustic", 0.8, 0.008, 0.014, 0.3),
        _material("grit", "grains of plaster", "granite", 0.7, 0.006, 0.075, 0.2),
        _material("plankton", "what lives in water", "jelly", 0.8, 0.012, 0.1, 0.6),
        _material("fibril", "strands of a fibre", "molecule", 0.9, 0.012, DEEP, 1.0, 26.0),
        _material("membrane", "folded membranes", "molecule", 0.9, 0.012, DEEP, 1.2, 26.0, "molecule"),
        _material("cytoplasm", "inside of a cell", "membrane", 0.9, 0.012, DEEP, 1.2, 26.0),
        _material("molecule", "great molecules", "helix", 0.9, 0.012, DEEP, 1.0, 26.0, "atom"),
        _material("lattice", "atoms in rows", "sea", 0.9, 0.012, DEEP, 0.4, 26.0),
        _material("facet", "cleaved crystal", "salt", 1.0, 0.012, DEEP, 0.8, 26.0),
        _material("jelly", "inside of a drifter", "ice", 0.9, 0.012, DEEP, 1.2, 26.0),
        _material("helix", "twisted chains", "atom", 0.9, 0.012, DEEP, 1.0, 26.0),
        _material("salt", "atoms of two kinds", "shell", 0.9, 0.012, DEEP, 0.4, 26.0),
        _material("shell", "clouds in rows", "nucleus", 0.9, 0.012, DEEP, 0.4, 26.0),
        _material("sea", "waves of electrons", "nucleus", 0.9, 0.012, DEEP, 0.4, 26.0),
        _material("ice", "cages of water", "dipole", 0.9, 0.012, DEEP, 0.6, 26.0),
        _material("dipole", "molecules of water", "orbital", 0.9, 0.012, DEEP, 0.6, 26.0),
        _material("strings", "what binds a kernel", "froth", 0.9, 0.012, DEEP, 0.6, 26.0),
        _material("weave", "cloth", "yarn", 0.9, 0.014, 0.05, 0.24, micro=0.03),
        _material("yarn", "threads of cloth", "fibre", 0.9, 0.014, 0.16, 0.24),
        _material("scales", "scales", "cornea", 0.9, 0.016, 0.05, 0.3),
        _material("tissue", "skin of a leaf", "cell", 0.9, 0.012, 0.13, 1.4),
        _material("caustic", "glints on water", "plankton", 0.7, 0.008, 0.07, 0),
        _material("atom", "bonded atoms", "orbital", 0.9, 0.012, DEEP, 0.6, 26.0),
        _material("orbital", "clouds of electrons", "nucleus", 0.9, 0.012, DEEP, 0.4, 26.0),
        _material("nucleus", "kernels of atoms", "strings", 0.9, 0.012, DEEP, 0.4, 26.0),
        _material("froth", "froth of nothing", "orbital", 0.9, 0.012, DEEP, 0.6, 26.0),
    )
}
"""Every material by name; the order is the order of the codes in no file, names are."""

_SYNONYMS = {
    "weave": "cloth fabric textile suit linen carpet sofa cushion shirt dress canvas",
    "venation": "leaf petal flower plant vein",
    "foliage": "foliage tree trees bush moss hedge forest grass leaves shrub",
    "fibre": "wood wooden timber plank fibre fiber muscle grain",
    "fur": "fur hair feather feathers coat animal",
    "straw": "straw hay thatch stalk stalks wheat",
    "bark": "bark trunk log",
    "rock": "rock stone cliff mountain wall brick concrete",
    "granite": "granite marble crystal mineral crystals",
    "sand": "sand gravel soil earth pebbles ground",
    "skin": "skin leather hide",
    "scales": "scales scale snake fish reptile dragon",
    "cell": "cell cells organism",
    "granule": "granule granules",
    "ripple": "water lake sea river pond ripple",
    "plaster": "plaster paint paper",
    "brushed": "metal steel iron brass",
    "smooth": "smooth glass ceramic porcelain plastic",
    "sky": "sky cloud clouds fog",
}
WORDS: dict[str, str] = {word: name for name, words in _SYNONYMS.items() for word in words.split()}
"""Material name by English word."""


def material_of_words(text: str) -> Material | None:
    """Returns the first material that the text names, by its own name or by a common word, else None."""
    for word in text.lower().replace(",", " ").replace(".", " ").split():
        name = word if word in MATERIALS else WORDS.get(word)
        if name is not None:
            return MATERIALS[name]
    return None


def closer(names: tuple[str, ...]) -> tuple[str, ...]:
    """Returns the names of what these materials are made of, eight times closer."""
    return tuple(MATERIALS[name].closer for name in names)


def per_label(names: tuple[str, ...], attribute: str) -> FloatArray:
    """Returns ``(n,)`` one attribute of every label's material, as a lookup table."""
    return np.array([getattr(MATERIALS[name], attribute) for name in names], np.float32)
