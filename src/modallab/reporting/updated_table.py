"""Parameters of a model that a test has corrected, as tables: the same words at every door."""

from modallab.core.digits import list_in_words, number_with_sigma, significant_digits
from modallab.core.documents.model_update import ParameterView, UpdatedView
from modallab.reporting.modified_table import TableRows
from modallab.updating.prior import Prior
from modallab.updating.result import UpdatedParameters


def parameter_rows(found: UpdatedParameters) -> TableRows:
    """Each parameter as it was believed and as it was found, with its 95 % interval."""
    rows = tuple(_parameter_row(found, name) for name in found.numbers)
    return TableRows(
        ("parameter", "believed", "found", "95 % interval", "determined"), rows, " ".join(_notes_on_parameters(found))
    )


def _parameter_row(found: UpdatedParameters, name: str) -> tuple[str, ...]:
    prior = found.priors[name]
    size, unit = (1e-9, "GPa") if prior.unit == "Pa" else (1.0, prior.unit)
    sigma = prior.sigma * prior.value if prior.relative else prior.sigma
    low, high, value = (_value_and_prior(v * size, prior) for v in (*found.interval[name], found.numbers[name]))
    determined = "no" if name in found.undetermined else "yes"
    title = f"{name} [{unit}]" if unit else name
    return title, number_with_sigma(size * prior.value, size * sigma), value, f"{low} to {high}", determined


def _value_and_prior(value: float, prior: Prior) -> str:
    return significant_digits(value, 5 if prior.value else 3)


def _notes_on_parameters(found: UpdatedParameters) -> list[str]:
    hz, shapes = found.off
    sentences = [
        f"With these the model's frequencies are off by about {100 * hz:.2g} %, its shapes by {100 * shapes:.2g} %."
    ]
    if found.undetermined:
        sentences.append(f"The test says little of {list_in_words(list(found.undetermined))} beside what was believed.")
    sentences += [f"Of {a} and {b} only a combination is known." for a, b in found.together]
    if found.held_out:
        before, after = (100 * e for e in found.rms_error(found.held_out))
        modes = list_in_words([str(r) for r in found.held_out])
        sentences.append(f"Held out, mode {modes}: frequency off by {before:.2g} % before, by {after:.2g} % after.")
    return sentences


def updated_mode_rows(found: UpdatedParameters) -> TableRows:
    """Each measured mode beside the model's, before and after."""
    before, after = found.errors
    rows = tuple(
        (
            str(r + 1),
            number_with_sigma(float(hz), float(found.measured_sigma_hz[r])),
            f"{100 * before[r]:+.3g}",
            f"{100 * after[r]:+.3g}",
            f"{found.before.mac[r]:.3f}",
            f"{found.after.mac[r]:.3f}",
            "held out" if r + 1 in found.held_out else "",
        )
        for r, hz in enumerate(found.measured_hz)
    )
    headings = ("mode", "measured [Hz]", "before [%]", "after [%]", "MAC before", "MAC after", "")
    return TableRows(headings, rows, "Frequencies of the model over the measured ones.")


def updated_document(found: UpdatedParameters) -> UpdatedView:
    """All numbers, as a document."""
    parameters = {
        name: ParameterView(
            believed=prior.value,
            found=found.numbers[name],
            interval=(found.interval[name][0], found.interval[name][1]),
            unit=prior.unit,
            determined=name not in found.undetermined,
        )
        for name, prior in found.priors.items()
    }
    return UpdatedView(
        parameters=parameters,
        together=found.together,
        held_out=found.held_out,
        measured_hz=found.measured_hz,
        before_hz=found.before.frequency_hz,
        after_hz=found.after.frequency_hz,
        mac_before=found.before.mac,
        mac_after=found.after.mac,
        notes=tuple(_notes_on_parameters(found)),
    )
