"""The desktop app: Algorithm 1, lines 1-9, in a window.

::

            window ── input (keys) ──┐                  ┌── panels: (state, ui) -> commands
                                     ▼                  ▼
    worker ── events ──► AppState ◄── apply ◄── commands (frozen, imperative)
      ▲                     │          │
      │                     │          ├─ viewing      zoom, orbit, pan, fly, fly-to        line 8
      │                     │          ├─ locating     where in the photo;  framing  the next camera
      │                     │          ├─ trail        back and forward
      └─ requests ──────────┼──────────┼─ generation   E_0, E_{i+1}, cancel, the queue      lines 1, 10
                            │          ├─ varying      another seed, and which variant is seen
                            │          ├─ prompting    known words, refusal;  words;  auto  asks by itself
                            │          ├─ documents    open, save, close;  dropping;  recovery  autosave
                            │          ├─ errands      files, read and written beside the frames;  listing
                            │          ├─ keeping      picture, command, film;  shooting  which
                            │          ├─ directing    keys of a film, and its preview
                            │          ├─ history      undo and redo of all that changes the scene
                            │          ├─ reopening    recent files;  hint  once, on the first photo
                            │          ├─ summoning    palette of commands, log window
                            │          └─ preferring   settings;  notices  details and retry
                            ▼
                   renderer.render(scene, camera) ──► window                                lines 6-7

Nothing changes the state but `apply`: panels and input only return commands, so each of them is
tested without a window.  ``loop`` holds the frame loop; ``window`` is the only module that knows glfw.
"""

import imgui_bundle  # noqa: F401 - before glfw anywhere: both must share the library that it ships
