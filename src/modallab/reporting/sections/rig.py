"""How it was measured: the bench, its channels, its blocks."""

from datetime import UTC, date, datetime

from modallab.core.block import Block, Campaign
from modallab.core.digits import (
    UNKNOWN,
    count_with_noun,
    iso_date,
    list_in_words,
    short_number,
    significant_digits,
    with_nonbreaking_spaces,
)
from modallab.core.hardware import Certificate
from modallab.core.rig import Beam, Channel, Rig
from modallab.core.units import BROADBAND, TESTS, Test
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.section import Section, paragraph


def rig_section(content: ReportContent) -> Section:
    """Rig, blocks and channels in plain words."""
    rig = content.rig
    parts: list[Markup] = [paragraph(_bench_table(rig))]
    blocks = _blocks_table(content.campaign)
    if blocks:
        header = ("test", "blocks", "length", "rate", "force at", "excitation")
        parts.append(html_table("Recordings", header, blocks))
    if content.campaign.frfs:
        sets = count_with_noun(len(content.campaign.frfs), "set of FRFs", "sets of FRFs")
        parts.append(paragraph(f"The source held {sets} without time records."))
    header = ("channel", "quantity", "point", "direction", "sensitivity [V per unit]", "serial number", "calibrated on")
    parts.append(html_table("Channels", header, [_channel_row(c) for c in rig.channels]))
    certified = [_certificate_row(c, c.certificate) for c in rig.channels if c.certificate is not None]
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
        parts.append(html_table("Certificates", header, certified))
    return Section(
        "rig",
        "How it was measured",
        join_markup(parts),
        (*_uncalibrated_channels(rig), *_expired_certificates(content.campaign)),
    )


def _uncalibrated_channels(rig: Rig) -> tuple[str, ...]:
    names = [c.name for c in rig.channels if c.calibrated_on is None]
    if not names:
        return ()
    which = "any channel" if len(names) == len(rig.channels) else list_in_words(names)
    return (f"The rig file gives no calibration date for {which}.",)


def _certificate_row(channel: Channel, certificate: Certificate) -> tuple[str, ...]:
    return (
        channel.name,
        certificate.number or "not given",
        certificate.laboratory or "not given",
        certificate.reference or "not given",
        iso_date(certificate.date),
        iso_date(certificate.expires),
        f"{short_number(certificate.uncertainty_percent)} %",
    )


def _expired_certificates(campaign: Campaign) -> tuple[str, ...]:
    # Of the days of the runs the last counts; a source that does not say when is judged as of today.
    days = [text[:10] for key, text in campaign.provenance.items() if key.endswith("created_utc")]
    on = date.fromisoformat(max(days)) if days else datetime.now(UTC).date()
    names = [
        c.name
        for c in campaign.rig.channels
        if c.certificate is not None and c.certificate.expires is not None and c.certificate.expires < on
    ]
    return (f"The certificate of {list_in_words(names)} had expired on {iso_date(on)}.",) if names else ()


def _bench_table(rig: Rig) -> str:
    text = f"The bench is “{rig.name}”."
    if rig.beam is not None:
        text += " " + _beam_in_words(rig.beam)
    sensors = rig.responses
    forces = "a force transducer" if len(rig.forces) < 2 else count_with_noun(len(rig.forces), "force transducer")
    text += f" {count_with_noun(len(sensors), 'sensor')} and {forces}"
    text += f" stood on {count_with_noun(len(rig.points), 'point')}." if rig.points else "; their places are not known."
    if rig.converter is not None:
        text += f" The converter has {rig.converter.bits} bit over ± {short_number(rig.converter.range_v)} V."
    return text


def _beam_in_words(beam: Beam) -> str:
    return (
        f"It is a cantilever {short_number(beam.length_m)} m long, {short_number(1e3 * beam.width_m)} mm wide and "
        f"{short_number(1e3 * beam.thickness_m)} mm thick, with a Young's modulus of "
        f"{short_number(beam.youngs_modulus_pa / 1e9)} "
        f"GPa and a density of {short_number(beam.density_kg_m3)} kg/m³. The rig file says of its clamp: "
        f"“{beam.clamp}”."
    )


def _blocks_table(campaign: Campaign) -> list[tuple[str, ...]]:
    return [_recordings_row(test, campaign.of(test)) for test in TESTS if campaign.of(test)]


def _recordings_row(test: Test, blocks: tuple[Block, ...]) -> tuple[str, ...]:
    lengths = sorted({round(b.duration_s, 9) for b in blocks})
    points = sorted({point for b in blocks for point in b.driven_points if point is not None})
    return (
        test,
        str(len(blocks)),
        with_nonbreaking_spaces(f"{list_in_words([short_number(v) for v in lengths])} s"),
        with_nonbreaking_spaces(f"{list_in_words([short_number(v) for v in sorted({b.rate_hz for b in blocks})])} Hz"),
        f"{'point' if len(points) == 1 else 'points'} {list_in_words([str(p) for p in points])}"
        if points
        else "not given",
        _excitation_in_words(test, blocks),
    )


def _excitation_in_words(test: Test, blocks: tuple[Block, ...]) -> str:
    if test == "impact":
        return "hammer"
    drives = sorted({b.frequency_hz for b in blocks if b.frequency_hz is not None})
    levels = sorted({b.level for b in blocks if b.level})
    if test in BROADBAND:
        return f"shaker, {test}, {count_with_noun(len(levels), 'level')} ({list_in_words(levels)})"
    text = f"shaker at {count_with_noun(len(drives), 'frequency', 'frequencies')}" if drives else "shaker"
    if drives:
        text += f" from {significant_digits(drives[0], 4)} to {significant_digits(drives[-1], 4)} Hz"
    return text + (f", {count_with_noun(len(levels), 'level')} ({list_in_words(levels)})" if levels else "")


def _sensitivity_text(channel: Channel) -> str:
    value = channel.sensitivity_v_per_unit
    if isinstance(value, dict):
        return list_in_words([f"{short_number(v)} ({test})" for test, v in value.items()])
    return "not given" if value is None else short_number(float(value))


def _channel_row(channel: Channel) -> tuple[str, ...]:
    return (
        channel.name,
        f"{channel.quantity} [{channel.unit.replace('^2', '²')}]",
        "not given" if channel.point is None else str(channel.point),
        channel.direction,
        _sensitivity_text(channel),
        channel.serial or "not given",
        iso_date(channel.calibrated_on),
    )


LONG = 120
"""A longer value is folded away."""


def provenance_section(content: ReportContent) -> Section:
    """Code version, seeds, hashes, rates, and the notes."""
    facts = content.provenance | content.campaign.provenance | _rates_in_words(content.campaign)
    if content.campaign.source:
        facts = {"campaign": content.campaign.source} | facts
    if content.truth is not None and content.truth.source:
        facts |= {"the truth is known from": content.truth.source}
    notes = html_element("ul", *(html_element("li", n) for n in content.notes)) if content.notes else None
    rows = [(what, _value_text(text)) for what, text in facts.items()]
    listing = html_table("Provenance", ("what", "value"), rows, class_="facts") if facts else None
    return Section("provenance", "Notes and provenance", join_markup([notes, listing]))


def _value_text(text: str) -> str:
    if len(text) <= LONG:
        return text
    return html_element("details", html_element("summary", f"{text[: LONG // 2]}…"), html_element("p", text))


def _rates_in_words(campaign: Campaign) -> dict[str, str]:
    facts: dict[str, str] = {}
    tests: tuple[Test, ...] = ("impact", "sine")
    for test in tests:
        blocks = campaign.of(test)
        if not blocks:
            continue
        facts[f"rates, {test} test"] = (
            f"requested {_range_of_values([b.requested_rate_hz for b in blocks])}, actual "
            f"{_range_of_values([b.actual_rate_hz for b in blocks])}, delivered "
            f"{_range_of_values([b.rate_hz for b in blocks])}"
        )
    return facts


def _range_of_values(values: list[float | None]) -> str:
    known = sorted({v for v in values if v is not None})
    return f"{list_in_words([f'{v:.10g}' for v in known])} Hz" if known else UNKNOWN
