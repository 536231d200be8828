"""The modal model in full."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.digits import rounded_to_sigma, scientific_text, significant_digits, three_digits
from modallab.core.model import ModalModel
from modallab.identification.estimator import estimator_of
from modallab.reporting.content import ReportContent
from modallab.reporting.figures.mode_shapes import sensor_label
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.section import Section, paragraph

_RESPONSE_METHODS = {
    "ssi_cov": "covariance-driven subspace identification of the responses alone",
    "plscf_spectra": "pLSCF on half spectra of the responses alone",
}
_UNSCALED = (
    "Without a force the shapes have no scale: each is 1 at its largest component. Modal masses and modal "
    "constants are not known, and no response to a force can be predicted."
)


def model_section(content: ReportContent) -> Section:
    """Modal constants, shapes and residuals of every model, folded away."""
    parts: list[Markup] = []
    for model in content.models:
        if model.n_modes:
            parts += _model_tables(model)
    if not parts:
        return Section("model", "The model in full", None)
    if all(model.operating_shapes is not None for model in content.models):
        return Section("model", "The model in full", join_markup([paragraph(_UNSCALED), *parts]))
    formula = paragraph(
        "The receptance is the sum over the modes of A / (ω₀² − ω² + 2jζω₀ω), with the modal constant A = φⱼφₖ of "
        "response point j and force point k at unit modal mass."
    )
    return Section("model", "The model in full", join_markup([formula, *parts]))


def _model_tables(model: ModalModel) -> list[Markup]:
    low, high = model.band_hz
    head = (
        f"{(model.test or 'FRFs').capitalize()}: {_method_in_words(model.method)}, {three_digits(low)} to "
        f"{three_digits(high)} Hz"
    )
    folds = [_folded_block("Modal constants", _constants_table(model))] if model.input_points else []
    if model.operating_shapes is not None:
        folds.append(
            _folded_block("Mode shapes without a scale", _operating_shapes_table(model, model.operating_shapes))
        )
    if model.shapes is not None:
        folds.append(_folded_block("Mode shapes at unit modal mass", _shapes_table(model)))
    if model.residual_powers:
        folds.append(_folded_block("What modes outside the band add", _residuals_table(model)))
    return [html_element("h3", head), *_scale_sentence(model), *folds]


def _scale_sentence(model: ModalModel) -> list[Markup]:
    scale = model.scale_uncertainty
    if scale is None:
        return []
    force = "not known" if scale.force is None else f"{_percent_of(scale.force)} %"
    text = (
        "The sigmas below include only the records' noise. The uncertainty of the sensitivities is the same in "
        f"every mode (one sigma): force {force}, responses {_span_of_values(scale.responses)}, "
        f"modal constants {_span_of_values(scale.modal_constants)}, shapes at unit modal mass "
        f"{_span_of_values(scale.shapes)}"
    )
    mass = "" if scale.modal_mass is None else f", modal mass {_percent_of(scale.modal_mass)} %"
    return [paragraph(f"{text}{mass}.")]


def _span_of_values(values: NDArray[np.float64]) -> str:
    known = values[np.isfinite(values)]
    if not known.size:
        return "not known"
    low, high = _percent_of(float(known.min())), _percent_of(float(known.max()))
    which = "" if known.size == values.size else f" for {known.size} of {values.size}"
    return f"{low} %{which}" if low == high else f"{low} to {high} %{which}"


def _percent_of(value: float) -> str:
    return significant_digits(100 * value, 2)


def _method_in_words(name: str) -> str:
    known = estimator_of(name)
    if name in _RESPONSE_METHODS:
        return _RESPONSE_METHODS[name]
    return name if known is None else known.title


def _folded_block(summary: str, *tables: Markup) -> Markup:
    return html_element("details", html_element("summary", summary), *tables)


def _constants_table(model: ModalModel) -> Markup:
    sigma, parts = model.modal_constant_sigma, model.modal_constant_part_sigma
    imag = sigma if parts is None else parts.imag
    return join_markup(
        html_table(
            f"Modal constants in kg⁻¹, {_force_of_input(model, k)}: value and sigma",
            ("response", *(f"mode {r + 1}" for r in range(model.n_modes))),
            [
                (
                    _point_of_output(model, j),
                    *(
                        _complex_text(model.modal_constants[r, j, k], sigma[r, j, k], imag[r, j, k])
                        for r in range(model.n_modes)
                    ),
                )
                for j in range(len(model.outputs))
            ],
            range(1, model.n_modes + 1),
        )
        for k in range(model.modal_constants.shape[2])
    )


def _shapes_table(model: ModalModel) -> Markup:
    assert model.shapes is not None
    return _table_by_point(model, model.shapes, model.shape_sigma, "Shapes φ in kg⁻¹ᐟ²: value and sigma")


def _operating_shapes_table(model: ModalModel, shapes: NDArray[np.complex128]) -> Markup:
    return _table_by_point(model, shapes, model.operating_shape_sigma, "Shapes, 1 at the largest: value and sigma")


def _table_by_point(
    model: ModalModel, shapes: NDArray[np.complex128], sigma: NDArray[np.float64] | None, caption: str
) -> Markup:
    known = np.full(shapes.shape, np.nan) if sigma is None else sigma
    rows = [
        (
            _point_of_output(model, j),
            *(_complex_text(complex(v), float(s), float(s)) for v, s in zip(phi, own, strict=True)),
        )
        for j, (phi, own) in enumerate(zip(shapes.T, known.T, strict=True))
    ]
    header = ("point", *(f"mode {r + 1}" for r in range(model.n_modes)))
    return html_table(caption, header, rows, range(1, model.n_modes + 1))


def _residuals_table(model: ModalModel) -> Markup:
    # As powers of s alone, the coefficients span sixty decades.
    size = (2 * np.pi * model.band_hz[1]) ** np.array(model.residual_powers, float)
    unit = f"ω₁ = 2π · {three_digits(model.band_hz[1])} rad/s"
    return join_markup(
        html_table(
            f"Residuals, {_force_of_input(model, k)}: coefficients of the powers of s/ω₁ in m/N, with {unit}",
            ("response", *(f"power {p}" for p in model.residual_powers)),
            [
                (
                    _point_of_output(model, j),
                    *(scientific_text(float(value)) for value in size * model.residuals[:, j, k]),
                )
                for j in range(len(model.outputs))
            ],
            range(1, len(model.residual_powers) + 1),
        )
        for k in range(model.residuals.shape[2])
    )


def _complex_text(value: complex, sigma: float, sigma_imag: float) -> str:
    known = bool(np.isfinite(sigma)) and sigma > 0
    text = rounded_to_sigma(value.real, sigma) if known else significant_digits(value.real, 3)
    # An imaginary part that its sigma hides is left out.
    if abs(value.imag) > 1e-9 * abs(value) and not abs(value.imag) < 2 * sigma_imag:
        size = rounded_to_sigma(abs(value.imag), sigma_imag) if known else significant_digits(abs(value.imag), 3)
        text += f" {'−' if value.imag < 0 else '+'} {size}j"
    return f"{text} ± {rounded_to_sigma(sigma, sigma)}" if known else text


def _point_of_output(model: ModalModel, output: int) -> str:
    return sensor_label(model.outputs[output], model.output_points[output])


def _force_of_input(model: ModalModel, k: int) -> str:
    point = model.input_points[k]
    return "force at an unknown point" if point is None else f"force at point {point}"
