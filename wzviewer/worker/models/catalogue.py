"""Names of the backends, for the command line; imports nothing heavy."""

BACKENDS = {
    "builtin": "no weights, no download: own network for depth, material texture, procedural objects",
}

WOULD_ADD = (
    "would add: any object or change in free words, people and scenes among them, where the builtin "
    "backend knows the words above; recognition of what a photograph shows, so that the petal is found "
    "by its name. It would cost a download and usually a GPU. None is part of this version."
)
