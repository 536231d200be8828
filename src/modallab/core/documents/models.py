"""Models, their judgement, comparisons and diagnoses as resources of campaigns and runs."""

from modallab.core.diagnosis import Diagnosis
from modallab.core.frozen import ComplexArray, Frozen, RealArray
from modallab.core.model import ModalModel

CURVES = "curves.json"
"""File of an identification with what its models are looked at by."""


class VerdictView(Frozen):
    """An assumption of the identification: whether it holds, the number that says so, and its limit.

    Attributes:
        assumption: which.
        holds: whether it does.
        value: the number that says so; null if there is none.
        limit: of that number; null if there is none.
        words: the same as a sentence.
    """

    assumption: str
    holds: bool
    value: float | None
    limit: float | None
    words: str


class Unjudged(Frozen):
    """An assumption that could not be judged.

    Attributes:
        assumption: which.
        why: it could not be judged.
    """

    assumption: str
    why: str


class AssessmentView(Frozen):
    """How far a model can be relied on.

    Attributes:
        verdicts: the assumptions that could be judged.
        unjudged: the others.
        confidence: (modes,) 0 to 1; null where not known.
        mpc: (modes,) modal phase collinearity.
        mpd_rad: (modes,) mean phase deviation.
        auto_mac: (modes, modes).
    """

    verdicts: tuple[VerdictView, ...]
    unjudged: tuple[Unjudged, ...]
    confidence: RealArray
    mpc: RealArray
    mpd_rad: RealArray
    auto_mac: RealArray


class TestModel(Frozen):
    """The model of one test.

    Attributes:
        model: modes, modal constants, residual terms, shapes.
        frac: (outputs, inputs) FRAC of measured and regenerated FRFs; None where it could not be formed.
        assessment: None where there is none.
        job: that computed it.
        runs: it is of.
        current: whether the blocks that count now are still those it was computed from.
    """

    __test__ = False

    job: str
    runs: tuple[str, ...]
    current: bool
    model: ModalModel
    frac: RealArray | None
    assessment: AssessmentView | None


class Missing(Frozen):
    """A test without a model.

    Attributes:
        test: which.
        error: why it has none.
    """

    test: str
    error: str


class ModelsView(Frozen):
    """The newest model of every test of a campaign or of a run.

    Attributes:
        job: the newest of those that computed them.
        runs: they are of.
        current: whether all of them are.
        code_version: of the modallab that computed the newest.
        models: the newest of each test.
        without_model: tests that gave none, and why.
    """

    job: str
    runs: tuple[str, ...]
    current: bool
    code_version: str
    models: tuple[TestModel, ...]
    without_model: tuple[Missing, ...]


class DiagnosisView(Frozen):
    """The newest diagnosis of a campaign; `current` as in the models.

    Attributes:
        job: that computed it.
        runs: it is of.
        current: whether the blocks that count now are still those it was computed from.
        code_version: of the modallab that computed it.
        sentence: the verdict in words, with units and 95 % intervals.
        numbers: those of what the gap behaves like: name with SI unit, value, 95 % interval or why there is none.
        diagnosis: itself.
    """

    job: str
    runs: tuple[str, ...]
    current: bool
    code_version: str
    sentence: str
    numbers: tuple[tuple[str, str, str], ...]
    diagnosis: Diagnosis


class ComparisonView(Frozen):
    """The modes that the models of two runs share, over the points that both have.

    Attributes:
        runs: the two.
        tests: the test of each model.
        modes: (pairs) places of a mode in the one and in the other, from 0.
        frequency_hz: (pairs, 2).
        difference_percent: (pairs,) of the second frequency from the first.
        sigmas: (pairs,) the same in joint sigmas; null where one is not known.
        damping_ratio: (pairs, 2).
        mac: (pairs,) of the shapes; None where fewer than two points are shared.
        points: that both have.
        comac: (points,); None as for `mac`.
        alone: (2,) places of the modes that only one has.
    """

    runs: tuple[str, str]
    tests: tuple[str | None, str | None]
    modes: tuple[tuple[int, int], ...]
    frequency_hz: RealArray
    difference_percent: RealArray
    sigmas: RealArray
    damping_ratio: RealArray
    mac: RealArray | None
    points: tuple[int, ...]
    comac: RealArray | None
    alone: tuple[tuple[int, ...], tuple[int, ...]]


class DiagramView(Frozen):
    """A stabilisation diagram.

    Attributes:
        order: (poles,) at which a pole was found.
        frequency_hz: (poles,).
        damping_ratio: (poles,).
        standing: (poles,) 0 new, 1 holds in frequency, 2 stable.
        held_hz: (held,) frequencies of the poles that hold over enough orders.
        line_hz: (lines,) of the mode indicator.
        cmif: (functions, lines) complex mode indicator function of the mobility, largest first, in (m/(N s))^2.
    """

    order: RealArray
    frequency_hz: RealArray
    damping_ratio: RealArray
    standing: RealArray
    held_hz: RealArray
    line_hz: RealArray
    cmif: RealArray


class TestCurves(Frozen):
    """What one test's model is looked at by; arrays of mobility are (outputs, inputs, lines) in m/(N s).

    Attributes:
        test: it is of.
        outputs: channel names.
        output_points: where they are; None where unknown.
        input_points: points that were driven.
        frequency_hz: (lines,).
        measured: from the blocks; None where there is no comparison.
        sigma: one standard deviation of each measured complex number; None where not known.
        regenerated: the model's response to the measured force, cut and treated as the blocks were.
        diagram: stabilisation diagram; None where there is none.
        without_diagram: why there is none, else "".
    """

    __test__ = False

    test: str | None
    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    frequency_hz: RealArray
    measured: ComplexArray | None
    sigma: RealArray | None = None
    regenerated: ComplexArray | None
    diagram: DiagramView | None
    without_diagram: str = ""


class CurvesView(Frozen):
    """What the newest models of a campaign are looked at by.

    Attributes:
        tests: one for each model, in their order.
    """

    tests: tuple[TestCurves, ...]
