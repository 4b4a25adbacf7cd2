"""Who builds which object."""

from wzviewer.worker.models.builtin.objects import (
    birds,
    butterflies,
    cats,
    crawlers,
    fishes,
    flowers,
    fungi,
    insects,
    leaves,
    lizards,
    molluscs,
    things,
    treasures,
)
from wzviewer.worker.models.builtin.objects.bodies import Builder

BUILDERS: dict[str, Builder] = {
    "ladybug": insects.ladybug,
    "beetle": insects.beetle,
    "butterfly": butterflies.butterfly,
    "blue morpho": butterflies.morpho,
    "cabbage white": butterflies.cabbage_white,
    "bee": crawlers.bee,
    "ant": crawlers.ant,
    "spider": crawlers.spider,
    "bird": birds.robin,
    "sparrow": birds.sparrow,
    "blue tit": birds.blue_tit,
    "cardinal": birds.cardinal,
    "canary": birds.canary,
    "crow": birds.crow,
    "fish": fishes.fish,
    "goldfish": fishes.goldfish,
    "clownfish": fishes.clownfish,
    "trout": fishes.trout,
    "lizard": lizards.lizard,
    "gecko": lizards.gecko,
    "cat": cats.cat,
    "snail": molluscs.snail,
    "conch shell": molluscs.conch,
    "starfish": treasures.starfish,
    "mushroom": fungi.mushroom,
    "flower": flowers.daisy,
    "sunflower": flowers.sunflower,
    "poppy": flowers.poppy,
    "cherry blossom": flowers.blossom,
    "leaf": leaves.leaf,
    "maple leaf": leaves.maple_leaf,
    "acorn": leaves.acorn,
    "feather": leaves.feather,
    "pebble": things.pebble,
    "water drop": things.drop,
    "crystal": treasures.crystal,
    "coin": treasures.coin,
    "key": treasures.key,
    "lego brick": things.brick,
}

FLYING: dict[str, Builder] = {
    f"{name} in flight": birds.in_flight(name) for name in ("bird", "sparrow", "blue tit", "cardinal", "crow")
}
"""What is drawn with spread wings if the prompt lets it fly."""
