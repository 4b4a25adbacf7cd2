"""The panels: functions of (state, ui) that draw with imgui and return commands.

::

    ┌ toolbar ─────────┐ ┌ ‹ › photo › breadcrumb ┐   ┌ toasts, look behind ┐
    │ open save … help │                                  └─────────────────────┘
    ├ tree ────────────┤
    │ ▣ photograph     │            the picture
    │ └ ▣ ×8 ladybug   │        ┌ variants ─────────┐
    │   └ ▣ ×64        │        │ queue             │                 ┌ locator ─┐
    └──────────────────┘        │ progress, offers  │                 │          │
    ┌ scale bar ┐               │ prompt [Generate] │                 ┌ status ──┐
    └───────────┘               └───────────────────┘                 └──────────┘

    frame     on the picture, below all: what the next level will show
    history   below the toolbar, as keep and settings
    start     instead of all, while there is no document; with recents; over one on request
    notices   where the toasts stand, and above them the film in the making
    hint      over the picture, below the breadcrumb, once
    help      over all, as log and palette;  dialogs  modal, with folder  to choose a file in

They change nothing: a test calls them with a state and reads the commands.
"""
