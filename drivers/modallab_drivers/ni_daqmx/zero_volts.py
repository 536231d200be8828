"""0 V on an analog output: one value where the device takes values on demand, else a short buffer of zeros."""

from typing import Any

import nidaqmx.errors
import numpy as np
from nidaqmx.constants import AcquisitionType, Edge

from modallab.core.errors import ConfigurationError
from modallab_drivers.ni_daqmx.errors import typed_error

GROUP_BY_CHANNEL = 0
WAIT_S = 1.0
CLOCKED_HZ = 10_000.0
CLOCKED = 16
"""Samples: some converters want several before they give the first."""


def write_zero(interpreter: Any, task: Any, outputs: int = 1) -> None:
    """Put 0 V on the outputs of an unused task; they then hold it.

    Args:
        interpreter: the package's way to the driver; past `Task.write`, which asks three times what it writes to.
        task: handle of a task without a clock.
        outputs: that it has.

    Raises:
        DaqError: the device rejected it.
    """
    try:
        interpreter.write_analog_f64(task, 1, True, WAIT_S, GROUP_BY_CHANNEL, np.zeros((outputs, 1)))
    except nidaqmx.errors.DaqError as error:
        # Converters that oversample want a clock.
        if not isinstance(typed_error(error, ""), ConfigurationError):
            raise
        edge, finite = Edge.RISING.value, AcquisitionType.FINITE.value
        interpreter.cfg_samp_clk_timing(task, CLOCKED_HZ, "", edge, finite, CLOCKED)
        interpreter.write_analog_f64(task, CLOCKED, True, WAIT_S, GROUP_BY_CHANNEL, np.zeros((outputs, CLOCKED)))
        interpreter.wait_until_task_done(task, WAIT_S)
