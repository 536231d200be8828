"""How it was measured: the bench, its channels, its blocks."""

from datetime import UTC, date, datetime

from modallab.core.block import Block, Campaign
from modallab.core.digits import counted, day, glued, listed, plain, short
from modallab.core.metrology import Certificate
from modallab.core.rig import Beam, Channel, Rig
from modallab.core.units import BROADBAND, TESTS, Test
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import Markup, join, table
from modallab.reporting.sections.section import Section, paragraph


def section(content: ReportContent) -> Section:
    """Rig, blocks and channels in plain words."""
    rig = content.rig
    parts: list[Markup] = [paragraph(_bench(rig))]
    blocks = _blocks(content.campaign)
    if blocks:
        header = ("test", "blocks", "length", "rate", "force at", "excitation")
        parts.append(table("Recordings", header, blocks))
    if content.campaign.frfs:
        sets = counted(len(content.campaign.frfs), "set of FRFs", "sets of FRFs")
        parts.append(paragraph(f"The source held {sets} and no time records for them."))
    header = ("channel", "quantity", "point", "direction", "sensitivity [V per unit]", "serial number", "calibrated on")
    parts.append(table("Channels", header, [_channel(c) for c in rig.channels]))
    certified = [_certificate(c, c.certificate) for c in rig.channels if c.certificate is not None]
    if certified:
        header = (
            "channel",
            "certificate",
            "laboratory",
            "reference",
            "calibrated on",
            "expires",
            "uncertainty (k = 2)",
        )
        parts.append(table("Certificates", header, certified))
    return Section("rig", "How it was measured", join(parts), (*_uncalibrated(rig), *_expired(content.campaign)))


def _uncalibrated(rig: Rig) -> tuple[str, ...]:
    names = [c.name for c in rig.channels if c.calibrated_on is None]
    if not names:
        return ()
    which = "any channel" if len(names) == len(rig.channels) else listed(names)
    return (f"The rig file gives no calibration date for {which}.",)


def _certificate(channel: Channel, certificate: Certificate) -> tuple[str, ...]:
    return (
        channel.name,
        certificate.number or "not given",
        certificate.laboratory or "not given",
        certificate.reference or "not given",
        day(certificate.date),
        day(certificate.expires),
        f"{short(certificate.uncertainty_percent)} %",
    )


def _expired(campaign: Campaign) -> tuple[str, ...]:
    # Of the days of the runs the last counts; a source that does not say when is judged as of today.
    days = [text[:10] for key, text in campaign.provenance.items() if key.endswith("created_utc")]
    on = date.fromisoformat(max(days)) if days else datetime.now(UTC).date()
    names = [
        c.name
        for c in campaign.rig.channels
        if c.certificate is not None and c.certificate.expires is not None and c.certificate.expires < on
    ]
    return (f"The certificate of {listed(names)} had expired on {day(on)}.",) if names else ()


def _bench(rig: Rig) -> str:
    text = f"The bench is “{rig.name}”."
    if rig.beam is not None:
        text += " " + _beam(rig.beam)
    sensors = rig.responses
    forces = "a force transducer" if len(rig.forces) < 2 else counted(len(rig.forces), "force transducer")
    text += f" {counted(len(sensors), 'sensor')} and {forces}"
    text += f" stood on {counted(len(rig.points), 'point')}." if rig.points else "; their places are not known."
    if rig.converter is not None:
        text += f" The converter has {rig.converter.bits} bit over ± {short(rig.converter.range_v)} V."
    return text


def _beam(beam: Beam) -> str:
    return (
        f"It is a cantilever {short(beam.length_m)} m long, {short(1e3 * beam.width_m)} mm wide and "
        f"{short(1e3 * beam.thickness_m)} mm thick, with a Young's modulus of {short(beam.youngs_modulus_pa / 1e9)} "
        f"GPa and a density of {short(beam.density_kg_m3)} kg/m³. The rig file says of its clamp: “{beam.clamp}”."
    )


def _blocks(campaign: Campaign) -> list[tuple[str, ...]]:
    return [_recordings(test, campaign.of(test)) for test in TESTS if campaign.of(test)]


def _recordings(test: Test, blocks: tuple[Block, ...]) -> tuple[str, ...]:
    lengths = sorted({round(b.duration_s, 9) for b in blocks})
    points = sorted({point for b in blocks for point in b.driven_points if point is not None})
    return (
        test,
        str(len(blocks)),
        glued(f"{listed([short(v) for v in lengths])} s"),
        glued(f"{listed([short(v) for v in sorted({b.rate_hz for b in blocks})])} Hz"),
        f"{'point' if len(points) == 1 else 'points'} {listed([str(p) for p in points])}" if points else "not given",
        _excitation(test, blocks),
    )


def _excitation(test: Test, blocks: tuple[Block, ...]) -> str:
    if test == "impact":
        return "hammer"
    drives = sorted({b.frequency_hz for b in blocks if b.frequency_hz is not None})
    levels = sorted({b.level for b in blocks if b.level})
    if test in BROADBAND:
        return f"shaker, {test}, {counted(len(levels), 'level')} ({listed(levels)})"
    text = f"shaker at {counted(len(drives), 'frequency', 'frequencies')}" if drives else "shaker"
    if drives:
        text += f" from {plain(drives[0], 4)} to {plain(drives[-1], 4)} Hz"
    return text + (f", {counted(len(levels), 'level')} ({listed(levels)})" if levels else "")


def _sensitivity(channel: Channel) -> str:
    value = channel.sensitivity_v_per_unit
    if isinstance(value, dict):
        return listed([f"{short(v)} ({test})" for test, v in value.items()])
    return "not given" if value is None else short(float(value))


def _channel(channel: Channel) -> tuple[str, ...]:
    return (
        channel.name,
        f"{channel.quantity} [{channel.unit.replace('^2', '²')}]",
        "not given" if channel.point is None else str(channel.point),
        channel.direction,
        _sensitivity(channel),
        channel.serial or "not given",
        day(channel.calibrated_on),
    )
