"""Trains in the browser: the explorer, and pages of one file.

`celltrain explore` serves a page on this machine (`server`, `app`); `celltrain page` writes a file
that needs nothing but a browser (`page`). Both draw with the scripts in `assets` and the figures of
`figures`; only the explorer needs the extra "explore" (Dash), and the page Plotly alone.
"""
