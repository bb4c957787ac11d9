"""A synthetic rig, with the truth beside its pictures: boards, films and scores."""

from helimag.vision.synthetic.motions import Kind, staged
from helimag.vision.synthetic.photographs import render_session
from helimag.vision.synthetic.rendering import render_run
from helimag.vision.synthetic.rig import Effects, paper_rig
from helimag.vision.synthetic.scoring import Score, score

__all__ = ["Effects", "Kind", "Score", "paper_rig", "render_run", "render_session", "score", "staged"]
