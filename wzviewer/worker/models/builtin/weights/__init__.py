"""Weights of the built-in networks, float16 safetensors files; read with `importlib.resources`."""
