"""Figures that are filmed too: the recording of a figure's first run becomes a video in its folder."""
from __future__ import annotations

import dataclasses
from typing import Any, Callable, Optional

from hapticd_lab.figure import Figure, Spec

RUN = "paper"
"""The run that is filmed: every figure with contact records it under this name."""
SPEED = 0.5
"""Recorded time per time of the video: plucks are over in a tenth of a second."""
MAGNIFY = 3.0
"""Strings are drawn so much thicker: 0.34 mm is less than a pixel."""
COST_S_PER_FIGURE = 120.0
WHOLE_SCENE = ("F10", "F11", "F12", "F13", "S1.2")
"""Figures, by the beginning of their id, that are seen from where the whole scene is in view; the others from close to the hand."""


def camera(figure_id: str) -> str:
    """The view of the page."""
    return "player" if figure_id.startswith(WHOLE_SCENE) else "close"


def filmed(spec: Spec, write_video: Optional[Callable[..., int]] = None) -> Spec:
    """The same figure, with a video. ValueError, when it is made, where it has no recording. `write_video`: as video.write_video."""

    def make(lab: Any, figure: Figure) -> None:
        spec.make(lab, figure)
        recording = lab.recording(RUN)
        if not recording.is_file():
            raise ValueError(f"{spec.id} has no session to film; leave it out of --video")
        write = write_video
        if write is None:
            from hapticd_lab.video import write_video as write  # needs a browser: only who films has it
        write(recording, lab.folder / f"{RUN}.webm", camera=camera(spec.id), magnify=MAGNIFY, speed=SPEED, caption=f"{spec.id}: {spec.title}")

    return dataclasses.replace(spec, make=make, cost_s=spec.cost_s + COST_S_PER_FIGURE)
