"""All calls by their names on the wire."""

from collections.abc import Callable
from functools import partial
from typing import Any

from modallab_simulators.ni_daqmx_server import events, teds
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls import (
    analog_inputs,
    channels,
    devices,
    sessions,
    timing,
    triggers,
    writes,
)  # fmt: skip
from modallab_simulators.ni_daqmx_server.calls.kinds import MEASURES
from modallab_simulators.ni_daqmx_server.calls.triggers import MOMENTS

Handler = Callable[[SimulatedSystem, Any], dict[str, Any]]

_INPUTS = (
    *(k for k in MEASURES if k not in ("ThrmstrIex", "ThrmstrVex", "VoltageWithExcit", "ForceBridge", "PressureBridge",
                                       "TorqueBridge")),
    *(f"{q}Bridge{form}" for q in ("Force", "Pressure", "Torque") for form in ("Polynomial", "Table", "TwoPointLin")),
)  # fmt: skip
_LAST = {"CreateAIThrmstrChanIex": "ThrmstrIex", "CreateAIThrmstrChanVex": "ThrmstrVex",
         "CreateAIVoltageChanWithExcit": "VoltageWithExcit"}  # fmt: skip
_TRIGGERS = {
    "CfgAnlgEdgeRefTrig": ("ANLG_EDGE", "REF"), "CfgAnlgEdgeStartTrig": ("ANLG_EDGE", "START"),
    "CfgAnlgMultiEdgeRefTrig": ("ANLG_MULTI_EDGE", "REF"), "CfgAnlgMultiEdgeStartTrig": ("ANLG_MULTI_EDGE", "START"),
    "CfgAnlgWindowRefTrig": ("ANLG_WIN", "REF"), "CfgAnlgWindowStartTrig": ("ANLG_WIN", "START"),
    "CfgDigEdgeRefTrig": ("DIG_EDGE", "REF"), "CfgDigEdgeStartTrig": ("DIG_EDGE", "START"),
    "CfgDigPatternRefTrig": ("DIG_PATTERN", "REF"), "CfgDigPatternStartTrig": ("DIG_PATTERN", "START"),
}  # fmt: skip
_MEASURING = ("AngEncoder", "AngVelocity", "CountEdges", "DutyCycle", "Freq", "GPSTimestamp", "LinEncoder",
              "LinVelocity", "Period", "PulseWidth", "SemiPeriod", "TwoEdgeSep")  # fmt: skip

HANDLERS: dict[str, Handler] = {
    "CreateTask": sessions.create_task,
    "LoadTask": sessions.load_task,
    "AddGlobalChansToTask": sessions.add_global,
    "ClearTask": sessions.clear_task,
    "StartTask": sessions.start_task,
    "StopTask": sessions.stop_task,
    "TaskControl": sessions.task_control,
    "IsTaskDone": sessions.is_task_done,
    "GetNthTaskChannel": sessions.channel_by_number,
    "GetNthTaskReadChannel": sessions.channel_by_number,
    "GetNthTaskDevice": sessions.device_by_number,
    "CreateDIChan": channels.add_inputs,
    "CreateDOChan": channels.add_outputs,
    "CfgSampClkTiming": timing.set_clock,
    "CfgImplicitTiming": timing.set_implicit,
    "CfgHandshakingTiming": timing.set_handshaking,
    "CfgChangeDetectionTiming": timing.set_change_detection,
    "CfgPipelinedSampClkTiming": timing.set_pipelined,
    "CfgBurstHandshakingTimingImportClock": timing.set_burst,
    "CfgBurstHandshakingTimingExportClock": timing.set_burst,
    "CfgTimeStartTrig": triggers.at_time,
    "DisableRefTrig": partial(triggers.disable, place="REF"),
    "DisableStartTrig": partial(triggers.disable, place="START"),
    "ExportSignal": triggers.export,
    "ConnectTerms": triggers.connect,
    "DisconnectTerms": triggers.disconnect,
    "WriteAnalogF64": writes.analog,
    "WriteAnalogScalarF64": writes.analog_scalar,
    "WriteDigitalLines": writes.lines,
    "WriteDigitalScalarU32": writes.digital_scalar,
    "WriteRaw": writes.raw,
    "WriteAnalogWaveforms": writes.analog_waveforms,
    "WriteDigitalWaveforms": writes.digital_waveforms,
    "CreateWatchdogTimerTask": devices.create_watchdog,
    "CreateWatchdogTimerTaskEx": devices.create_watchdog,
    "ControlWatchdogTask": devices.control_watchdog,
    "PerformBridgeShuntCalEx": devices.shunt,
    "PerformStrainShuntCalEx": devices.shunt,
    "PerformBridgeOffsetNullingCalEx": devices.null,
    "PerformThrmcplLeadOffsetNullingCal": devices.null,
    "ResetDevice": devices.reset_device,
    "SelfTestDevice": devices.self_test,
    "SelfCal": devices.self_test,
    "GetExtCalLastDateAndTime": devices.calibrated_at,
    "GetSelfCalLastDateAndTime": devices.calibrated_at,
    "DeviceSupportsCal": devices.supports_calibration,
    "GetErrorString": devices.error_string,
    "CalculateReversePolyCoeff": devices.reverse_coefficients,
    "TristateOutputTerm": devices.nothing,
    "ConfigureLogging": devices.configure_logging,
    "StartNewFile": devices.start_new_file,
    "UnregisterDoneEvent": partial(events.unregister, key="done"),
    "UnregisterEveryNSamplesEvent": partial(events.unregister, key="every"),
    "UnregisterSignalEvent": partial(events.unregister, key="signal"),
    "RestoreLastExtCalConst": devices.self_test,
    "SaveGlobalChan": devices.save_channel,
    "SaveScale": devices.nothing,
    "ConfigureTEDS": teds.configure,
    "ClearTEDS": teds.clear,
} | MOMENTS
HANDLERS.update({f"CreateAI{kind}Chan": partial(analog_inputs.add_inputs, call=kind) for kind in _INPUTS})
HANDLERS.update({call: partial(analog_inputs.add_inputs, call=kind) for call, kind in _LAST.items()})
HANDLERS.update({f"CreateTEDSAI{kind}Chan": partial(analog_inputs.add_teds, call=kind) for kind in MEASURES})
HANDLERS.update({c.replace("AI", "TEDSAI"): partial(analog_inputs.add_teds, call=kind) for c, kind in _LAST.items()})
HANDLERS.update({f"CreateAO{kind}Chan": partial(channels.add_analog, kind=kind) for kind in channels.TYPES})
HANDLERS.update({f"CreateCI{kind}Chan": partial(channels.add_measuring, kind=kind) for kind in _MEASURING})
HANDLERS.update(
    {f"CreateCIPulseChan{k}": partial(channels.add_measuring, kind=f"Pulse{k}") for k in ("Freq", "Time", "Ticks")}
)
HANDLERS.update(
    {f"CreateCOPulseChan{k}": partial(channels.add_generating, kind=f"Pulse{k}") for k in ("Freq", "Time", "Ticks")}
)
HANDLERS.update({call: partial(triggers.configure, kind=k, place=p) for call, (k, p) in _TRIGGERS.items()})
HANDLERS.update({call: partial(writes.codes, call=call) for call in writes.CODES})
HANDLERS.update({f"WriteDigitalU{n}": partial(writes.digital, call=f"WriteDigitalU{n}") for n in (8, 16, 32)})
HANDLERS.update(
    {
        f"WriteCtr{k}{s}": partial(writes.pulses, call=f"WriteCtr{k}{s}")
        for k in ("Freq", "Time", "Ticks")
        for s in ("", "Scalar")
    }
)
HANDLERS.update(
    {f"CfgWatchdog{k}ExpirStates": partial(devices.set_watchdog_states, kind=k) for k in ("AO", "CO", "DO")}
)
HANDLERS.update({f"Create{k}Scale": partial(devices.make_scale, kind=k) for k in ("Lin", "Map", "Polynomial", "Table")})
_SAVED = {"DeleteSavedScale": "Scale", "DeleteSavedTask": "Task", "DeleteSavedGlobalChan": "Channel"}
HANDLERS.update({call: partial(devices.delete, kind=k) for call, k in _SAVED.items()})
