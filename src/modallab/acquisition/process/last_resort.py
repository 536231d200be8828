"""What an owner can still do when the process that drove is dead."""

from modallab.bench.loader import open_output
from modallab.core.rig import Rig


def zero_from_outside(url: str, rig: Rig) -> str:
    """Bring the output to 0 V when the process that drove it is dead; what came of it, for the end of a sentence.

    Empty where no output outlives its process.
    """
    try:
        output = open_output(url, rig)
        if output is None:
            return ""
        try:
            output.zero()
        finally:
            output.close()
    except Exception as error:
        return f"; the output could not be brought to 0 V from here, switch the amplifier off: {error}"
    return "; the output was brought to 0 V from outside"
