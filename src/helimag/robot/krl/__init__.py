"""KUKA Robot Language: programmes written, read back and compared with their plan."""

from helimag.robot.krl.comparison import Deviation, deviation
from helimag.robot.krl.files import krl_texts
from helimag.robot.krl.interpreter import Playback, play
from helimag.robot.krl.writer import checked_name, write_krl

__all__ = ["Deviation", "Playback", "checked_name", "deviation", "krl_texts", "play", "write_krl"]
