"""What a run is, simulated or measured: its trajectory, gain and verdict, and how far two runs agree."""

from helimag.outcomes import End, Reason, Verdict
from helimag.runs import measurement
from helimag.runs.comparison import Comparison, compare
from helimag.runs.gain import Judgement, gain_until, judge, judge_each
from helimag.runs.heights import Heights, SlowTimes
from helimag.runs.imported import import_track
from helimag.runs.leading import leading_end, path_cosine
from helimag.runs.measurement import interval_text
from helimag.runs.netcdf import read_netcdf, write_netcdf
from helimag.runs.smoothing import smooth
from helimag.runs.tables import Columns, read_table
from helimag.runs.trajectory import Trajectory, versions

__all__ = [
    "Columns",
    "Comparison",
    "End",
    "Heights",
    "Judgement",
    "Reason",
    "SlowTimes",
    "Trajectory",
    "Verdict",
    "compare",
    "gain_until",
    "import_track",
    "interval_text",
    "judge",
    "judge_each",
    "leading_end",
    "measurement",
    "path_cosine",
    "read_netcdf",
    "read_table",
    "smooth",
    "versions",
    "write_netcdf",
]
