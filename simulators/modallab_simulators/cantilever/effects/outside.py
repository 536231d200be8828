"""Effects that no catalogue names, for practising what to say then."""

from modallab.core.effects import EffectKind, Parameter

_OUTSIDE = (
    EffectKind(
        "torsion",
        "structure",
        (Parameter("offset", "m", 1e-5, 0.05),),
        "all",
        "hammer, shaker and sensors stand off the beam's middle line by offset, and so twist it and feel it twist",
    ),
    EffectKind(
        "support_resonance",
        "structure",
        (Parameter("mass", "kg", 1e-5, 1.0, "m"), Parameter("hz", "Hz", 5.0, 200.0)),
        "x",
        "a mass on a spring at x, with a resonance of its own at hz",
    ),
    EffectKind(
        "axial_preload",
        "structure",
        (Parameter("force", "N", 1e-3, 5e3, signed=True),),
        "all",
        "the beam is pulled by force along its axis, or pushed where it is negative",
    ),
    EffectKind(
        "cross_axis",
        "sensor",
        (Parameter("share", "", 1e-4, 0.5),),
        "all",
        "hits, shaker and sensors have a share across the drive's direction, in which the beam has modes of its own",
    ),
    EffectKind(
        "preamp_lag",
        "sensor",
        (Parameter("corner_hz", "Hz", 20.0, 1e6),),
        "channel",
        "one accelerometer passes a first-order low-pass, -3 dB at corner_hz",
    ),
    EffectKind(
        "soft_saturation",
        "sensor",
        (Parameter("volts", "V", 0.05, 1e4),),
        "channel",
        "one channel reads v / sqrt(1 + (v / volts)^2)",
        linear=False,
    ),
    EffectKind(
        "dropouts",
        "acquisition",
        (Parameter("share", "", 1e-5, 0.3),),
        "channel",
        "a share of one channel's samples is lost and reads 0",
    ),
    EffectKind(
        "timing_jitter",
        "acquisition",
        (Parameter("seconds_rms", "s", 1e-9, 1e-3),),
        "all",
        "every sampling instant is off by a random time of seconds_rms, the same for all rows",
    ),
    EffectKind(
        "amplifier_harmonics",
        "excitation",
        (Parameter("share", "", 1e-4, 0.5),),
        "shaker",
        "the power amplifier makes v (1 + share v / V + share (v / V)^2) of v, with V = 5 V; the force channel sees it",
        ("sine",),
    ),
)

OUTSIDE: dict[str, EffectKind] = {k.name: k for k in _OUTSIDE}
"""Every effect with a name of its own here, in the order of the stages."""

AMPLIFIER_V = 5.0
