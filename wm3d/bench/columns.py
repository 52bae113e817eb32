"""The columns of stored rows and their types, by kind of cell."""

TRIALS = {
    "mesh": "str",
    "scheme": "str",
    "scheme_parameters": "str",
    "attack": "str",
    "attack_parameters": "str",
    "hypothesis": "str",
    "subject": "str",
    "trial": "int64",
    "statistic": "float64",
    "z": "float64",
    "log10_p": "float64",
    "snr_db": "float64",
    "axis_deg": "float64",
    "faces_out": "int64",
    "seconds": "float64",
    "embed_seconds": "float64",
    "attack_seconds": "float64",
    "score_seconds": "float64",
    "error": "str",
    "bit_error_rate": "float64",
    "log10_p_least": "float64",
    "embed_mb": "float64",
}
"""One row a score. `mesh` is the mesh whose key is scored, `subject` the one that was attacked and read;
`seconds` is the time of attack and scoring, `embed_seconds` that of embedding, of which the first key of a
block may pay for what a scheme keeps for the next ones. Scores are NaN where the attack failed.
`bit_error_rate` is that of marked meshes, NaN for schemes without a message; `log10_p_least` is the log10 of
the least p-value that any key reaches on the mesh that was read, and `embed_mb` the memory of embedding the
first key of a block (`bench.memory`), NaN for the others."""

ADDED = {"bit_error_rate", "log10_p_least", "embed_mb"}
"""Columns that cells of earlier versions lack; they read as NaN."""

NOT_MARKED = "not marked: "
"""How the `error` of a trial begins whose mesh the scheme refused to mark."""

FALSE_ALARMS = {
    "mesh": "str",
    "scheme": "str",
    "scheme_parameters": "str",
    "attack": "str",
    "attack_parameters": "str",
    "z": "float64",
    "exceedances": "int64",
    "keys": "int64",
    "pf_low": "float64",
    "pf_high": "float64",
    "log10_p": "float64",
}
"""One row a threshold `z`: how many of the random `keys` reached it, the 95 % interval of Pf from
independent batches of keys, and log10 of the exact tail."""

CALIBRATION = {
    "mesh": "str",
    "scheme": "str",
    "method": "str",
    "budget": "str",
    "metric": "str",
    "wanted": "float64",
    "reached": "float64",
    "parameter": "str",
    "strength": "float64",
    "seconds": "float64",
    "error": "str",
}
"""One row a mesh, scheme and budget. `scheme` names the budget too, `method` does not; `parameter` is the one
that was set to `strength`. Where no strength meets the budget, both numbers are NaN and `error` says so."""

TRY_AGAIN = "wm3d.try-again"
"""Key of `DataFrame.attrs`, true for the rows of a cell that met an error that wm3d did not foresee, such as
that of a full disk: the next run makes them again. What wm3d refuses it would refuse again."""

GONE = "its worker died or ran out of memory each time"
"""The `error` of trials and calibrations that left nothing behind."""

LOST = "wm3d.lost"
"""Key of `DataFrame.attrs`, true for rows that no worker made, for each died or ran out of memory."""

COLUMNS = {"trials": TRIALS, "false-alarms": FALSE_ALARMS, "calibration": CALIBRATION}
"""By `wm3d.bench.plan.Cell.kind`."""
