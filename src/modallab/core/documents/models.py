"""Models, their judgement, comparisons and diagnoses as resources of campaigns and runs."""

from modallab.core.diagnosis import Diagnosis
from modallab.core.frozen import ComplexArray, Frozen, RealArray
from modallab.core.model import ModalModel

CURVES = "curves.json"
"""File of an identification with what its models are looked at by."""


class VerdictView(Frozen):
    """Test of an assumption of the identification: result, number and limit.

    Attributes:
        assumption: which.
        holds: whether the assumption holds.
        value: number of the test; null if there is none.
        limit: limit of that number; null if there is none.
        words: comparison as a sentence.
    """

    assumption: str
    holds: bool
    value: float | None
    limit: float | None
    words: str


class UnjudgedAssumption(Frozen):
    """An assumption that could not be tested.

    Attributes:
        assumption: which.
        why: reason.
    """

    assumption: str
    why: str


class AssessmentView(Frozen):
    """How reliable a model is.

    Attributes:
        verdicts: assumptions that were tested.
        unjudged: assumptions that could not be tested.
        confidence: (modes,) 0 to 1; null where not known.
        mpc: (modes,) modal phase collinearity.
        mpd_rad: (modes,) mean phase deviation.
        auto_mac: (modes, modes).
    """

    verdicts: tuple[VerdictView, ...]
    unjudged: tuple[UnjudgedAssumption, ...]
    confidence: RealArray
    mpc: RealArray
    mpd_rad: RealArray
    auto_mac: RealArray


class TestModel(Frozen):
    """The model of one test.

    Attributes:
        model: modes, modal constants, residual terms, shapes.
        frac: (outputs, inputs) FRAC of measured and regenerated FRFs; None if undefined.
        assessment: assessment of the model; None if there is none.
        job: name of the job.
        runs: it is of.
        current: whether the valid blocks are still those of the computation.
    """

    __test__ = False

    job: str
    runs: tuple[str, ...]
    current: bool
    model: ModalModel
    frac: RealArray | None
    assessment: AssessmentView | None


class TestWithoutModel(Frozen):
    """A test without a model.

    Attributes:
        test: name of the test.
        error: reason for the missing model.
    """

    test: str
    error: str


class ModelsView(Frozen):
    """The newest model of every test of a campaign or of a run.

    Attributes:
        job: name of the newest job.
        runs: names of the runs.
        current: whether all models are current.
        code_version: version of modallab of the newest model.
        models: newest model of each test.
        without_model: tests without a model, and the reason.
    """

    job: str
    runs: tuple[str, ...]
    current: bool
    code_version: str
    models: tuple[TestModel, ...]
    without_model: tuple[TestWithoutModel, ...]


class DiagnosisView(Frozen):
    """The newest diagnosis of a campaign; `current` as in the models.

    Attributes:
        job: name of the job.
        runs: it is of.
        current: whether the valid blocks are still those of the computation.
        code_version: version of modallab.
        sentence: the verdict in words, with units and 95 % intervals.
        numbers: numbers of the description: name with SI unit, value, 95 % interval or the reason for its absence.
        diagnosis: diagnosis itself.
    """

    job: str
    runs: tuple[str, ...]
    current: bool
    code_version: str
    sentence: str
    numbers: tuple[tuple[str, str, str], ...]
    diagnosis: Diagnosis


class ComparisonView(Frozen):
    """The common modes of two runs' models, over their common points.

    Attributes:
        runs: names of the two runs.
        tests: test of each model.
        modes: (pairs) indices of a mode in both models, from 0.
        frequency_hz: (pairs, 2).
        difference_percent: (pairs,) second frequency relative to the first.
        sigmas: (pairs,) difference in joint sigmas; null if one sigma is unknown.
        damping_ratio: (pairs, 2).
        mac: (pairs,) MAC of the shapes; None with fewer than two common points.
        points: common points.
        comac: (points,) CoMAC; None as for `mac`.
        alone: (2,) indices of modes that only one model has.
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
        order: (poles,) order at which a pole was found.
        frequency_hz: (poles,).
        damping_ratio: (poles,).
        standing: (poles,) 0 new, 1 stable in frequency, 2 stable.
        held_hz: (held,) frequencies of the poles that are stable over enough orders.
        line_hz: (lines,) frequencies of the mode indicator.
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
    """Curves of one test's model; arrays of mobility are (outputs, inputs, lines) in m/(N s).

    Attributes:
        test: it is of.
        outputs: channel names.
        output_points: points of the outputs; None if unknown.
        input_points: driven points.
        frequency_hz: (lines,).
        measured: mobility from the blocks; None without a comparison.
        sigma: standard deviation of each measured complex number; None if unknown.
        regenerated: the model's response to the measured force, cut and processed like the blocks.
        diagram: stabilisation diagram; None if there is none.
        without_diagram: reason for the missing diagram, otherwise "".
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
    """Curves of the newest models of a campaign.

    Attributes:
        tests: curves of each model, in the order of the models.
    """

    tests: tuple[TestCurves, ...]
