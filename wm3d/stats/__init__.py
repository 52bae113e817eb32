"""False alarms and ROC curves of detectors for ±1 keys; knows nothing of meshes."""

from wm3d.stats.false_alarm import FalseAlarm, false_alarm
from wm3d.stats.importance import ImportanceEstimate, importance_sampling
from wm3d.stats.intervals import Interval, clopper_pearson, korn_graubard, quoted, student_t, tolerance_bound
from wm3d.stats.montecarlo import Exceedances, hadamard_keys, independent_keys
from wm3d.stats.rademacher import DEFAULT_PF, RademacherSum, Score, key_signs, key_signs_batch
from wm3d.stats.roc import (
    RocCurve,
    auc,
    d_prime,
    eer,
    exceedances,
    roc,
)
from wm3d.stats.saddlepoint import saddlepoint_log10
from wm3d.stats.tail import hoeffding_log10, log10_tail, z_at

__all__ = [
    "DEFAULT_PF",
    "Exceedances",
    "FalseAlarm",
    "ImportanceEstimate",
    "Interval",
    "RademacherSum",
    "RocCurve",
    "Score",
    "auc",
    "clopper_pearson",
    "d_prime",
    "eer",
    "exceedances",
    "false_alarm",
    "hadamard_keys",
    "hoeffding_log10",
    "importance_sampling",
    "independent_keys",
    "key_signs",
    "key_signs_batch",
    "korn_graubard",
    "log10_tail",
    "quoted",
    "roc",
    "saddlepoint_log10",
    "student_t",
    "tolerance_bound",
    "z_at",
]
