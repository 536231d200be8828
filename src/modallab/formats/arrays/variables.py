"""Variables with names, of whichever file: as a map says, as the file itself does, or by the usual names."""

from pathlib import Path

import numpy as np

from modallab.core.block import Campaign
from modallab.core.rig import Rig
from modallab.formats.arrays.arrays_draft import draft_arrays
from modallab.formats.arrays.mapped import campaign_of_map
from modallab.formats.arrays.named import FREQUENCY, TIME, Arrays, Texts, campaign_of_arrays, unit_beside, usual_name
from modallab.formats.arrays.names_in_file import names_in_file
from modallab.formats.arrays.scaled import scaled_arrays
from modallab.formats.axis_units import is_of_frequency, is_of_time, to_hertz, to_seconds
from modallab.formats.csv.clock_times import is_clock, seconds_of
from modallab.formats.options import ImportOptions


def campaign_of_variables(arrays: Arrays, texts: Texts, path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record, or one matrix of FRFs, as a map says, the file itself, or the usual names.

    Raises:
        DataError: variables that are missing or do not fit.
    """
    found = options.array_map
    arrays = _abscissae(scaled_arrays({**arrays, **_clocks(texts)}, str(path)), texts, options)
    if found is None and not options.variables:
        arrays, texts, found = names_in_file(arrays, texts, rig, str(path))
    if found is not None:
        return campaign_of_map(arrays, found, path.stem, rig, options, str(path))
    return campaign_of_arrays(arrays, path.stem, rig, options, str(path), texts)


def _clocks(texts: Texts) -> Arrays:
    """The columns of clock times among texts, in s."""
    found = {key: rows for key, rows in texts.items() if len(rows) > 1 and all(map(is_clock, rows))}
    return {key: np.array(seconds_of(rows), np.float64) for key, rows in found.items()}


def _abscissae(arrays: Arrays, texts: Texts, options: ImportOptions) -> Arrays:
    """The arrays, those of times in s and of frequencies in Hz where the file gives them another unit."""
    found, said = dict(arrays), dict(options.variables)
    for key, values in arrays.items():
        unit = unit_beside(texts, key).partition(" since ")[0] or key.rpartition("_")[2]
        for what, is_of, factor in ((TIME, is_of_time, to_seconds), (FREQUENCY, is_of_frequency, to_hertz)):
            if is_of(unit) and factor(unit) != 1 and (said.get(what) == key or usual_name({key: values}, what)):
                found[key] = values * factor(unit)
    return found


def rig_of_variables(arrays: Arrays, texts: Texts, path: Path, options: ImportOptions) -> Rig:
    """The rig that variables are of, as a map says, the file itself, or the usual names.

    Raises:
        DataError: what a variable is cannot be known.
    """
    found = options.array_map
    if found is None:
        arrays, texts, found = names_in_file(arrays, texts, None, str(path))
    return draft_arrays(arrays, texts, found, path, options.drive_point)
