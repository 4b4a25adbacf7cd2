"""Words of the prompt grammar; plain data, so that help and completion need nothing heavy."""

_SYNONYMS: dict[str, str] = {
    "ladybug": "lady bug; ladybird; lady bird; ladybird beetle; ladybug beetle; ladybeetle",
    "beetle": "bug; ground beetle; scarab; insect; carabid",
    "butterfly": "monarch; monarch butterfly",
    "blue morpho": "morpho; morpho butterfly; blue morpho butterfly",
    "cabbage white": "cabbage butterfly; cabbage white butterfly",
    "bee": "honeybee; honey bee; bumblebee; bumble bee; wasp",
    "ant": "wood ant; red ant",
    "spider": "garden spider; cross spider; tarantula",
    "bird": "robin; robin redbreast; songbird; little bird",
    "sparrow": "house sparrow; finch",
    "blue tit": "tit; bluetit; titmouse; chickadee",
    "cardinal": "red cardinal",
    "canary": "canary bird; yellow bird",
    "crow": "raven; blackbird; jackdaw; rook",
    "fish": "perch",
    "goldfish": "gold fish; koi; carp",
    "clownfish": "clown fish; anemone fish; anemonefish; nemo",
    "trout": "salmon",
    "lizard": "wall lizard; salamander; newt; reptile",
    "gecko": "leopard gecko",
    "cat": "kitten; kitty; tabby; tabby cat; tomcat; house cat",
    "snail": "garden snail",
    "conch shell": "conch; shell; sea shell; seashell; whelk; sea snail",
    "starfish": "sea star; seastar; star fish",
    "mushroom": "toadstool; fly agaric; fungus; shroom",
    "flower": "daisy; marguerite; chamomile; daisy flower; ox eye daisy",
    "sunflower": "sunflower head; sun flower",
    "poppy": "poppy flower; corn poppy",
    "cherry blossom": "blossom; sakura; apple blossom; peach blossom",
    "leaf": "green leaf; beech leaf",
    "maple leaf": "autumn leaf; fallen leaf; fall leaf; dead leaf",
    "acorn": "oak nut; nut",
    "feather": "plume; quill",
    "pebble": "stone; rock",
    "water drop": "drop; droplet; dewdrop; dew drop; raindrop; rain drop; waterdrop; water droplet; "
    "drop of water; drop of dew",
    "crystal": "amethyst; quartz; gem; gemstone; crystal cluster",
    "coin": "gold coin; penny; cent; doubloon; copper coin; silver coin",
    "key": "old key; skeleton key; door key",
    "lego brick": "brick; lego; toy brick; building brick; lego block; toy block",
}

NAMES: dict[str, str] = {name: name for name in _SYNONYMS} | {
    word: name for name, words in _SYNONYMS.items() for word in words.split("; ")
}
PLURALS = {
    "leaves": "leaf",
    "maple leaves": "maple leaf",
    "autumn leaves": "autumn leaf",
    "fallen leaves": "fallen leaf",
    "fungi": "fungus",
    "fishes": "fish",
    "starfishes": "starfish",
    "conches": "conch",
    "pennies": "penny",
}
"""Plurals that no rule makes."""

_RELATIVES: dict[str, str] = {
    "cat": "dog puppy fox rabbit mouse squirrel tiger lion bear horse cow sheep animal pet",
    "bird": "eagle owl parrot duck pigeon dove swan hummingbird penguin chicken seagull",
    "fish": "shark whale dolphin ray eel seahorse",
    "lizard": "frog toad snake turtle tortoise dragon dinosaur crocodile chameleon iguana",
    "bee": "fly dragonfly mosquito hornet firefly cicada",
    "beetle": "grasshopper cricket cockroach mantis",
    "butterfly": "moth caterpillar",
    "spider": "scorpion crab tick",
    "starfish": "octopus jellyfish coral urchin",
    "snail": "slug worm clam oyster",
    "flower": "rose tulip lily orchid dandelion carnation aster",
    "leaf": "tree grass fern ivy clover plant",
    "acorn": "apple cherry berry strawberry pear walnut chestnut fruit",
    "crystal": "diamond ruby emerald jewel",
    "coin": "ring medal button",
    "lego brick": "dice cube toy block",
}
KIN: dict[str, str] = {word: name for name, words in _RELATIVES.items() for word in words.split()}
"""What is not known, and the known object that comes nearest; only refusals use it."""
USUAL_SIZE = 0.40
"""Of the view's width, where neither a word nor the scene says more."""
COUNTS = {
    **dict.fromkeys(("a", "an", "the", "one", "single", "1"), 1),
    **{
        "two": 2,
        "pair": 2,
        "2": 2,
        "three": 3,
        "3": 3,
        "few": 4,
        "four": 4,
        "4": 4,
        "five": 5,
        "5": 5,
        "some": 4,
    },
    **{"several": 6, "six": 6, "6": 6, "seven": 7, "7": 7, "eight": 8, "8": 8, "many": 9, "nine": 9, "9": 9},
}
SIZES = {
    **dict.fromkeys(("tiny", "minute", "miniature"), 0.12),
    **dict.fromkeys(("small", "little"), 0.22),
    **dict.fromkeys(("big", "large"), 0.6),
    **dict.fromkeys(("huge", "giant", "enormous"), 0.8),
}
COLORS = {
    "red": (200, 18, 12),
    "crimson": (150, 12, 30),
    "orange": (235, 110, 14),
    "yellow": (236, 190, 18),
    "green": (52, 128, 38),
    "blue": (28, 78, 196),
    "cyan": (30, 168, 190),
    "turquoise": (30, 168, 160),
    "purple": (108, 44, 150),
    "violet": (112, 58, 180),
    "pink": (232, 120, 160),
    "white": (232, 228, 216),
    "black": (38, 35, 34),
    "grey": (128, 126, 122),
    "gray": (128, 126, 122),
    "brown": (112, 66, 36),
    "golden": (226, 160, 40),
    "gold": (226, 160, 40),
    "silver": (190, 192, 196),
    "copper": (190, 100, 56),
    "bronze": (150, 104, 52),
    "brass": (206, 166, 84),
    "steel": (170, 174, 180),
    "iron": (110, 110, 114),
}
PATTERNS = {
    "spotted": "spotted",
    "dotted": "spotted",
    "striped": "striped",
    "banded": "striped",
    "plain": "plain",
    "spotless": "plain",
}
SUBSTANCES: dict[str, str] = {
    **dict.fromkeys(
        (
            "metal",
            "metallic",
            "golden",
            "gold",
            "silver",
            "copper",
            "bronze",
            "brass",
            "steel",
            "iron",
            "shiny",
        ),
        "metal",
    ),
    **dict.fromkeys(("wooden", "wood", "oak"), "wood"),
    **dict.fromkeys(("stone", "rock", "granite", "stony"), "stone"),
    **dict.fromkeys(("marble", "porcelain", "ceramic"), "marble"),
    **dict.fromkeys(("glass", "crystal", "transparent"), "glass"),
    **dict.fromkeys(("ice", "icy", "frozen"), "ice"),
    **dict.fromkeys(("mossy", "moss"), "moss"),
    **dict.fromkeys(("rusty", "rusted", "rust", "corroded"), "rust"),
    **dict.fromkeys(("plastic",), "plastic"),
}
CHANGES: dict[str, str] = {
    **dict.fromkeys(("moss", "mossy", "overgrown", "lichen"), "moss"),
    **dict.fromkeys(("rust", "rusty", "rusted", "corroded"), "rust"),
    **dict.fromkeys(("dust", "dusty"), "dust"),
    **dict.fromkeys(
        ("snow", "snowy", "snowing", "snows", "snowfall", "snowflakes", "winter", "wintry"), "snow"
    ),
    **dict.fromkeys(("frost", "frosty", "frosted", "frozen", "icy", "rime"), "frost"),
    **dict.fromkeys(("dew", "dewy"), "dew"),
    **dict.fromkeys(("rain", "rainy", "raining", "rains", "wet"), "rain"),
    **dict.fromkeys(("fog", "foggy", "mist", "misty", "haze", "hazy"), "fog"),
    **dict.fromkeys(("sunset", "dusk", "sunrise", "dawn", "evening"), "sunset"),
    **dict.fromkeys(("night", "nighttime", "moonlight", "moonlit", "midnight"), "night"),
}
LIGHTS = frozenset({"fog", "sunset", "night", "rain"})
"""Changes that "at", "in" or "under" may introduce: "a bird at night"."""
AMOUNTS = {
    **dict.fromkeys(
        ("light", "lightly", "slight", "slightly", "bit", "thin", "some", "little", "patchy"), 0.45
    ),
    **dict.fromkeys(
        ("thick", "thickly", "heavy", "heavily", "deep", "completely", "fully", "dense", "very"), 1.0
    ),
}
USUAL_AMOUNT = 0.75
ADJECTIVES = frozenset(
    """beautiful cute pretty lovely nice old young new fresh wild real realistic bright dark pale ripe fine
    happy sleepy curious fat thin long short round live living colorful colourful detailed single another
    more glossy fluffy furry hairy""".split()
)
"""Words that change nothing and do no harm."""
JOINTS = frozenset(
    "covered coated overgrown made carved cast built dusted sprinkled dripping wet clad sculpted".split()
)
"""Participles after which "in", "with", "of" or "from" bring a substance or a change."""
FILLERS = frozenset(
    """everything all it make makes turn let scene whole place now there falling fresh weather day time light
    with of in by at the a an be is are hour golden morning while after during under""".split()
)
PREPOSITIONS = {
    "on",
    "onto",
    "in",
    "at",
    "near",
    "by",
    "upon",
    "over",
    "above",
    "beside",
    "inside",
    "to",
    "along",
    "under",
    "below",
    "beneath",
    "among",
    "from",
}
RELATIONS: dict[str, str] = {
    **dict.fromkeys(("near", "by", "beside"), "beside"),
    **dict.fromkeys(("under", "below", "beneath"), "under"),
}
"""Where a preposition puts an object; the others put it on its place."""
ABOVE = frozenset({"over", "above"})
ALOFT = frozenset({"sky", "cloud", "clouds"})
FLIGHT = frozenset({"flying", "flies", "hovering", "hovers"})
FLIERS = (
    *("butterfly", "blue morpho", "cabbage white", "bee"),
    *("bird", "sparrow", "blue tit", "cardinal", "crow"),
)
"""What is drawn with open wings; of the others "flying" is not understood."""
SMALL = frozenset({*FLIERS[:4], "ladybug", "beetle", "ant", "spider", "snail", "water drop"})
"""What is drawn no larger than the flower or leaf that it sits on."""
WATERS = frozenset("water lake pond river sea wave puddle".split())
WITHIN = frozenset({"in", "inside", "under", "below", "beneath"})
"""Prepositions that put an object below the surface of water."""
VERBS = {
    "sitting",
    "sits",
    "resting",
    "crawling",
    "perched",
    "standing",
    "lying",
    "walking",
    "landing",
    "there",
    "is",
    "with",
    "of",
    *"""flying flies swimming swims sleeping eating drinking climbing climbs blooming growing grows hovering
    hovers running jumping hiding floating floats basking lies lays sits standing stands leaning feeding
    gathering crawls walks that which its underwater""".split(),
}
WHERE = {
    "left": (-0.24, 0.0),
    "right": (0.24, 0.0),
    "top": (0.0, -0.22),
    "upper": (0.0, -0.22),
    "bottom": (0.0, 0.22),
    "lower": (0.0, 0.22),
    "centre": (0.0, 0.0),
    "center": (0.0, 0.0),
    "middle": (0.0, 0.0),
}
SURFACES = frozenset(
    """petal petals leaf leaves flower flowers blossom bloom stem stalk branch twig bark trunk tree bush
    plant grass moss meadow field ground soil earth sand beach rock rocks stone stones boulder cliff
    mountain hill slope snow ice water lake pond river sea wave puddle wall roof house building window
    door floor table chair sofa couch carpet rug pillow cushion cloth fabric wood plank board bench
    shelf street road path pavement cobblestones cobblestone bridge car bicycle wheel metal glass paper
    book hand finger skin fur feather fruit apple mushroom sunflower rose disc disk seed seeds side
    corner edge surface picture image view scene foreground background photo here it sky cloud clouds
    village tower statue painting canvas frame lamp screen fence gate step steps stair stairs staircase
    tile tiles brickwork pot vase basket bed desk""".split()
)


_LOOKS: dict[str, str] = {
    "petal": "petal petals blossom bloom rose",
    "flower": "flower flowers",
    "disc": "disc disk seed seeds",
    "sunflower": "sunflower",
    "green": "leaf leaves stem stalk tree bush plant grass moss meadow",
    "white": "snow ice paper",
    "stone": "rock rocks stone stones boulder cliff mountain statue cobblestones cobblestone pavement",
    "wood": "branch twig bark trunk wood plank board bench basket",
    "water": "water lake pond river sea wave puddle",
    "bare": "sand beach soil earth path street road floor carpet rug tile tiles bridge",
    "lying": "ground field hill slope foreground table desk bed step steps stair stairs staircase shelf",
    "standing": "wall house building window door gate village tower fence brickwork background",
    "sky": "sky cloud clouds",
}
LOOKS: dict[str, str] = {word: look for look, words in _LOOKS.items() for word in words.split()}
"""How a place is found in a picture, see `places`; the other places are the view's middle."""


def known_words() -> dict[str, tuple[str, ...]]:
    """Returns every word a prompt may use, by its part in the sentence; "objects" holds one name each."""
    return {
        "objects": tuple(_SYNONYMS),
        "names": tuple(NAMES),
        "counts": tuple(COUNTS),
        "sizes": tuple(SIZES),
        "colors": tuple(COLORS),
        "patterns": tuple(PATTERNS),
        "substances": tuple(SUBSTANCES),
        "changes": tuple(CHANGES),
        "places": tuple(sorted(SURFACES | set(WHERE))),
    }
