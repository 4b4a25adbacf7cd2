"""Names of the backends, for the command line; imports nothing heavy."""

BACKENDS = {
    "builtin": "no weights, no download: own network for depth, material texture, procedural objects",
}
