"""Every effect declares all that the program needs of it; what is missing is said in a sentence."""

import re
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

import pytest
from added_effect import NAME, added, page_files

import modallab.twin.effects as twin
import modallab_simulators.cantilever.effects as bench
from modallab.core.rig import Beam
from modallab.gap.report.effect_inspection import INSPECTIONS
from modallab.twin.effect_model import EffectModel, EffectSearch, NoChange
from modallab_simulators.cantilever.effect_part import EffectPart

BEAM = Beam(length_m=1.0, width_m=0.05, thickness_m=0.006, youngs_modulus_pa=2e11, density_kg_m3=7850.0)
UNIT = re.compile(r"(kg|m|s|N|V|Hz|rad)(\^[2-4])?([ /](kg|m|s|N|V|Hz|rad)(\^[2-4])?)*")
TWIN, BENCH = "src/modallab/twin/effects", "simulators/modallab_simulators/cantilever/effects"


def names() -> list[str]:
    """Every module of either side."""
    return sorted({info.name for package in (twin, bench) for info in iter_modules(package.__path__)})


def lacking(name: str) -> list[str]:
    """What the files of an effect lack, a sentence each."""
    part, found = _declared(bench, BENCH, name, "PART", EffectPart)
    if isinstance(part, EffectPart):
        if part.name != name:
            found.append(f"{BENCH}/{name}.py calls its effect {part.name!r}: give file and effect one name")
        if part.outside is not None:
            return found
    model, more = _declared(twin, TWIN, name, "MODEL", EffectModel)
    found += more
    return found + (_of_model(name, model) if isinstance(model, EffectModel) else [])


def _declared(package: ModuleType, folder: str, name: str, what: str, kind: type) -> tuple[object, list[str]]:
    if name not in {info.name for info in iter_modules(package.__path__)}:
        return None, [f"{name} has no part here: add {folder}/{name}.py"]
    try:
        value = getattr(import_module(f"{package.__name__}.{name}"), what, None)
    except TypeError as error:
        return None, [f"{folder}/{name}.py: {error}"]
    return value, [] if isinstance(value, kind) else [f"{folder}/{name}.py declares no {what} = {kind.__name__}(...)"]


def _of_model(name: str, model: EffectModel) -> list[str]:
    kind = model.kind
    inspected = model.change is NoChange.NO_FORCE_PREDICTS_IT
    problems = {
        f"calls its effect {kind.name!r}: give file and effect one name": kind.name != name,
        "has no line that says what it does: fill `says`": not kind.says.strip(),
        "has no words for a diagnosis to speak of it: fill `spoken`": not model.spoken.strip(),
        "has no experiment that shows it apart: fill `experiment` with a sentence": not _is_sentence(model.experiment),
        "does not say whether it moves the poles: `moves_poles`": not isinstance(model.moves_poles, bool),
        "does not say whether a bench has it once: `once`": not isinstance(model.once, bool),
        "has a change of the twin and no `search`, or the other way round": isinstance(model.change, NoChange)
        is not (model.search is None),
        "is predicted by no force: add an inspection to gap/report/effect_inspection.py": inspected
        and name not in INSPECTIONS,
        "has an inspection in gap/report/effect_inspection.py and a change of the twin": not inspected
        and name in INSPECTIONS,
        "names rivals that are no effects": any(
            r.effect and r.effect not in twin.effect_models() for r in model.rivals
        ),
        "has a rival without an experiment or a plan": any(not (r.experiment or r.plan) for r in model.rivals),
    }
    found = [f"{TWIN}/{name}.py {what}" for what, there in problems.items() if there]
    for p in kind.parameters:
        if not isinstance(p.unit, str) or (p.unit and not UNIT.fullmatch(p.unit)):
            found.append(f"{TWIN}/{name}.py: the unit of {p.name} is {p.unit!r}: use SI units, or '' for a pure number")
        elif not 0 < p.low <= p.high:
            found.append(f"{TWIN}/{name}.py: the range of {p.name} is {p.low:g} to {p.high:g}")
    return found + (_of_search(name, model, model.search) if model.search is not None else [])


def _of_search(name: str, model: EffectModel, search: EffectSearch) -> list[str]:
    slots = {s.name: s for s in search.slots(BEAM)}
    parameters = {p.name: p for p in model.kind.parameters}
    expected = {*parameters, *(["x"] if model.kind.place == "x" else [])}
    found: list[str] = []
    # How a law is drawn beside its parameters, which no rig and no truth states, counts for nothing: its power is 0.
    more = {s.name for s in slots.values() if s.name not in expected and s.power != 0.0}
    if more or not expected <= {*slots, *dict(search.fixed)} or not {*dict(search.fixed)} <= expected:
        found.append(f"{TWIN}/{name}.py: slots and fixed numbers are not {', '.join(sorted(expected))}")
    for slot in slots.values():
        if slot.name in parameters and slot.none != parameters[slot.name].none:
            found.append(f"{TWIN}/{name}.py: {slot.name} is no effect at {slot.none:g} here, at another number there")
        if slot.transform == "plain" and slot.name != "x" and not any(v > 0 for v in slot.starts):
            found.append(f"{TWIN}/{name}.py: {slot.name} has no first value above 0")
    return found


def _is_sentence(text: str) -> bool:
    return len(text.split()) > 3 and text.endswith(".")


@pytest.mark.parametrize("name", names())
def test_both_files_declare_all_there_is_to_an_effect(name: str):
    assert lacking(name) == []


def test_the_pages_effect_lacks_nothing(tmp_path: Path):
    with added(tmp_path, *page_files()):
        assert NAME in names()
        assert lacking(NAME) == []


@pytest.mark.parametrize(
    ("left_out", "said"),
    [
        ("    moves_poles=True,\n", "'moves_poles'"),
        ("    once=True,\n", "'once'"),
        ('    spoken="slope spring",\n', "'spoken'"),
        ("    search=EffectSearch(rank=65, slots=_slots),\n", "'search'"),
        ("    change=_change,\n", "'change'"),
        (
            '    experiment="Take the bracket off and repeat the hits: all frequencies fall if it held the slope.",\n',
            "'ex",
        ),
        ('"N m/rad", ', "unit"),
        ("MODEL = ", "declares no MODEL"),
    ],
)
def test_what_the_twins_file_leaves_out_is_named(left_out: str, said: str, tmp_path: Path):
    twin_file, bench_file = page_files()
    assert left_out in twin_file
    with added(tmp_path, twin_file.replace(left_out, ""), bench_file):
        assert [said in sentence and NAME in sentence for sentence in lacking(NAME)] == [True]


@pytest.mark.parametrize(
    ("written", "instead", "said"),
    [
        ('"N m/rad"', '"pound"', "the unit of k_slope is 'pound'"),
        ('"slope spring"', '""', "`spoken`"),
        ("Take the bracket off and repeat the hits: all frequencies fall if it held the slope.", "", "`experiment`"),
        ("search=EffectSearch(rank=65, slots=_slots)", "search=None", "`search`"),
        ('"slope_spring",', '"slopespring",', "one name"),
        ('RivalEffect("ground_spring"', 'RivalEffect("gremlin"', "rivals"),
        ("change=_change", "change=NoChange.NO_FORCE_PREDICTS_IT", "effect_inspection.py"),
        (", along_beam())", ",)", "slots"),
    ],
)
def test_what_the_twins_file_says_wrongly_is_named(written: str, instead: str, said: str, tmp_path: Path):
    twin_file, bench_file = page_files()
    twin_file = twin_file.replace("import EffectModel,", "import EffectModel, NoChange,")
    with added(tmp_path, twin_file.replace(written, instead), bench_file):
        assert any(said in sentence for sentence in _lacking_alone())


def _lacking_alone() -> list[str]:
    # A file of another name than its effect is an error of the discovery too.
    model, found = _declared(twin, TWIN, NAME, "MODEL", EffectModel)
    assert isinstance(model, EffectModel)
    if model.kind.name != NAME:
        with pytest.raises(Exception, match="give the module the name of its effect"):
            twin.effect_models()
        return [f"{TWIN}/{NAME}.py calls its effect {model.kind.name!r}: give file and effect one name"]
    return found + lacking(NAME)


def test_a_missing_file_is_named(tmp_path: Path):
    twin_file, bench_file = page_files()
    for number, (files, folder) in enumerate((((twin_file, None), BENCH), ((None, bench_file), TWIN))):
        own = tmp_path / str(number)
        own.mkdir()
        with added(own, *files):
            assert lacking(NAME) == [f"{NAME} has no part here: add {folder}/{NAME}.py"]


@pytest.mark.parametrize("left_out", ["    several=True,\n", "    change=_change,\n", "    rank=85,\n"])
def test_what_the_benchs_file_leaves_out_is_named(left_out: str, tmp_path: Path):
    twin_file, bench_file = page_files()
    assert left_out in bench_file
    with added(tmp_path, twin_file, bench_file.replace(left_out, "")):
        (sentence,) = lacking(NAME)
        assert repr(left_out.strip().partition("=")[0]) in sentence
