"""False alarms and ROC curves of detectors for ±1 keys; knows nothing of meshes."""

from wm3d.stats.rademacher import DEFAULT_PF, RademacherSum, Score, key_signs, key_signs_batch
from wm3d.stats.tail import hoeffding_log10, log10_tail, saddlepoint_log10, z_at

__all__ = [
    "DEFAULT_PF",
    "RademacherSum",
    "Score",
    "hoeffding_log10",
    "key_signs",
    "key_signs_batch",
    "log10_tail",
    "saddlepoint_log10",
    "z_at",
]
