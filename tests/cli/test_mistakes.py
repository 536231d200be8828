"""What a newcomer gets wrong: each ends at once, in one sentence and a remedy, and never in a traceback."""

import io
import json
import re
import shutil
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest
from made_diagnosis import made_diagnosis
from scipy.io import savemat

from modallab.cli import main
from modallab.cli.demo import demo_rig
from modallab.core.effects import Effect
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import write_rig

DATA = Path(__file__).parents[1] / "data"
MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what a newcomer has lying about."""
    folder = tmp_path_factory.mktemp("newcomer")
    write_rig(demo_rig(), folder / "rig.yaml")
    shutil.copy(DATA / "campaign_v2.h5", folder / "campaign.h5")
    write_rig(read_campaign(DATA / "campaign_v2.h5").rig, folder / "campaign_rig.yaml")
    (folder / "notes.txt").write_text("a run_log of the test\n")
    (folder / "empty.h5").touch()
    (folder / "empty.csv").touch()
    (folder / "empty").mkdir()
    (folder / "empty.yaml").touch()
    (folder / "photo.yaml").write_bytes(bytes(range(256)))
    (folder / "models.json").write_text(json.dumps({"format_version": 1, "models": []}))
    (folder / "list.json").write_text("[1, 2]")
    (folder / "table.csv").write_text("time,force\n0,1\n")
    shutil.copy(DATA / "campaign_v2.h5", folder / "campaign_2.h5")
    (folder / "page.html").write_text(f"<!DOCTYPE html>\n<p>{'1, ' * 50_000}</p>\n")
    write_rig(demo_rig().model_copy(update={"limits": None}), folder / "rig_free.yaml")
    (folder / "half.h5").write_bytes((DATA / "campaign_v2.h5").read_bytes()[:3000])
    (folder / "grüße aus köln").mkdir()
    (folder / "d.json").write_text(made_diagnosis(demo_rig(), MASS).model_dump_json())
    (folder / "unknown.json").write_text(made_diagnosis(demo_rig(), verdict="unknown").model_dump_json())
    (folder / "map_word.yaml").write_text("the force is F\n")
    (folder / "map_field.yaml").write_text("{frf: H, freq: f}\n")
    savemat(folder / "analyser.mat", {"H": [[1.0, 2.0]], "f": [1.0, 2.0]})
    (folder / "rig_mm.yaml").write_text((folder / "rig.yaml").read_text().replace("length_m: 0.777", "length_m: 777"))
    (folder / "rig_gpa.yaml").write_text(
        (folder / "rig.yaml").read_text().replace("youngs_modulus_pa: 205000000000.0", "youngs_modulus_pa: 205")
    )
    plans = {
        "tabs": "kind: impact\n\tpoints: [10]\n",
        "kindless": "points: [10]\n",
        "kind": "kind: hammer\n",
        "field": "kind: impact\npoint: 10\n",
        "value": "kind: impact\npoints: [10]\nhits: -1\n",
        "word": "just a word\n",
        "second": "- {kind: impact, points: [10]}\n- {kind: sine, levels_v: 3}\n",
        "far": "kind: impact\npoints: [99]\n",
        "level": "kind: sine\nfrequencies_hz: [20, 40]\nlevels_v: {low: strong}\n",
        "alone": "kind: impact\npoints: 10\n",
        "names": "kind: impact\npoints: [tip]\n",
        "two": "kind: impact\npoints: [10]\n---\nkind: sine\n",
        "long": "kind: impact\npoints: [10]\nblock_s: 1024\n",
        "loud": "kind: sine\nfrequencies_hz: [20]\nlevels_v: {low: 50}\n",
    }
    for name, text in plans.items():
        (folder / f"plan_{name}.yaml").write_text(text)
    return folder


MISTAKES = {
    # The demo.
    "demo --out notes.txt": "notes.txt: is a file",
    "demo --out notes.txt/inside": "notes.txt/inside: cannot be written",
    "demo --effect mass": "no effect is called 'mass'",
    "demo --effect added_mass": "x is missing",
    "demo --effect added_mass,mass=0.05": "write it as added_mass,mass=",
    "demo --effect added_mass,m=0.05,x=0.8": "has no parameter 'm'; allowed: mass",
    "demo --effect added_mass,mass=50g,x=0.8": "mass is '50g'; allowed: above 0 kg",
    "demo --effect added_mass,mass=0.05,x=8": "a share of the length from the clamp",
    "demo --effect swap,channel=3": "two accelerometers, such as a03:a07",
    "demo --effect gain_error,gain=1.1,channel=a99": "99",
    "demo --effect=": "no effect is called ''",
    "demo --seed -1": "seed is '-1'; allowed: a whole number from 0",
    "gap effects mass": "no effect is called 'mass'",
    # Recordings.
    "identify nowhere.h5": "nowhere.h5: ",
    "identify empty": "empty: is a folder without campaign.h5",
    "identify notes.txt": "notes.txt: ",
    "identify empty.h5": "empty.h5: ",
    "identify half.h5": "half.h5: ",
    "identify models.json": "models.json: ",
    "identify campaign.h5 --band 80 3": "there is no band 80 to 3 Hz",
    "identify campaign.h5 --band 1 2": "Hz",
    "identify campaign.h5 --pick -5": "--pick is '-5'; allowed: more than 0",
    "identify campaign.h5 --test chirp": "there is no block of a chirp test",
    "identify campaign.h5 --rig nowhere.yaml": "nowhere.yaml: cannot be read",
    "identify campaign.h5 --rig photo.yaml": "photo.yaml: is not text in UTF-8",
    "identify campaign.h5 --rig empty.yaml": "empty.yaml: is empty",
    "identify campaign.h5 --rig notes.txt": "notes.txt: ",
    "import notes.txt --rig rig.yaml --out new.h5": "notes.txt: ",
    "import table.csv --rig rig.yaml --out new.h5": "table.csv",
    "import campaign.h5 --rig campaign.h5 --out new.h5": "campaign.h5: is not text",
    "import campaign.h5 --rig rig.yaml --out campaign.h5": "is one of the sources",
    "export campaign.h5 --format uff --out nowhere/x.uff": "nowhere",
    "export notes.txt --format csv --out x": "notes.txt: ",
    # The gap.
    "gap diagnose nowhere.h5": "nowhere.h5: ",
    "gap diagnose campaign.h5 --hold-out some": "some",
    "gap predict campaign.h5 --diagnosis models.json --on campaign.h5 --out p.h5": "holds modal models",
    "gap predict campaign.h5 --diagnosis list.json --on campaign.h5 --out p.h5": "list.json: is no diagnosis",
    "gap predict campaign.h5 --diagnosis photo.yaml --on campaign.h5 --out p.h5": "photo.yaml: is no diagnosis",
    "gap predict campaign.h5 --diagnosis nowhere --on campaign.h5 --out p.h5": "nowhere: cannot be read",
    # Plans.
    "gap distinguishability rig.yaml nowhere.yaml": "nowhere.yaml: cannot be read",
    "gap distinguishability rig.yaml empty.yaml": "empty.yaml: holds no test",
    "gap distinguishability rig.yaml photo.yaml": "photo.yaml: is not text in UTF-8",
    "gap distinguishability rig.yaml plan_tabs.yaml": "plan_tabs.yaml: is not YAML: line 2",
    "gap distinguishability rig.yaml plan_kindless.yaml": "no kind is given; allowed: impact, sine, broadband",
    "gap distinguishability rig.yaml plan_kind.yaml": "no test is of kind 'hammer'",
    "gap distinguishability rig.yaml plan_field.yaml": "point is an unknown field; allowed: kind, points",
    "gap distinguishability rig.yaml plan_value.yaml": "hits is -1; allowed: more than 0",
    "gap distinguishability rig.yaml plan_word.yaml": "'just a word' is no test",
    "gap distinguishability rig.yaml plan_second.yaml": "test 2: levels_v is 3",
    "gap distinguishability rig.yaml plan_far.yaml": "99",
    # Benches and the service.
    "devices nonsense": "nonsense",
    "rig check nowhere.yaml": "nowhere.yaml: cannot be read",
    "rig check rig.yaml --bench cDAQ1": "no driver for the bench address 'cDAQ1'",
    "rig check rig.yaml --bench sim://plate": "no simulated bench at 'sim://plate'",
    "rig check rig.yaml --bench sim://cantilever?sed=1": "unknown parameter 'sed'",
    "serve --rig nowhere.yaml": "nowhere.yaml: cannot be read",
    "serve --host 0.0.0.0 --data served": "no token was chosen",
    "restore notes.txt --out back": "notes.txt",
    "user list --data notes.txt": "notes.txt",
    # Words that are no command, no option, or no number.
    "identfy campaign.h5": "did you mean identify?",
    "gap campaign.h5": "ACTION is 'campaign.h5'; allowed: diagnose",
    "gap": "ACTION is missing",
    "identify campaign.h5 --bnd 3 110": "did you mean --band?",
    "identify campaign.h5 --band 3-110": "write it as --band LO HI",
    "identify campaign.h5 --band 3Hz 110Hz": "--band is '3Hz'; allowed: a number",
    "identify campaign.h5 --method lscf": "did you mean plscf?",
    "import campaign.h5 --rig rig.yaml": "--out is missing",
    "export campaign.h5 --format UFF --out x.uff": "did you mean uff?",
    "demo --seed 1.5": "--seed is '1.5'; allowed: a whole number",
    "demo heavy": "modallab demo does not take 'heavy'",
    "demo --effect added_mass mass=0.05": "does not take 'mass=0.05'",
    "rig mass rig.yaml --mass 500g --when before --into empty": "--mass is '500g'",
    "rig mass rig.yaml --mass -1 --when before --into empty": "--mass is '-1'; allowed: more than 0",
    "rig check rig.yaml --seconds 0": "--seconds is '0'",
    "serve --port 99999": "port is 99999; allowed: 65535 or less",
    # A result in the place of what it is made of, or where it cannot be.
    "identify campaign.h5 --json campaign.h5": "campaign.h5: is one of the sources",
    "identify . --report campaign.h5": "campaign.h5: is one of the sources",
    "identify nowhere.h5 --report half.h5": "half.h5",
    "identify campaign.h5 --json nowhere/models.json": "there is no folder nowhere",
    "identify campaign.h5 --json empty": "empty: is a folder",
    "export campaign.h5 --format uff --out campaign.h5": "is one of the sources",
    "export campaign.h5 --format csv --out notes.txt": "notes.txt: is a file",
    "campaign run --rig rig.yaml --plan plan_far.yaml --out rig.yaml": "is one of the sources",
    "gap paper --json .": "is a folder",
    "gap blind --out notes.txt": "notes.txt: is a file",
    "gap apply models.json --rig rig.yaml --out rig.yaml": "is one of the sources",
    # One file for another.
    "gap distinguishability plan_far.yaml rig.yaml": "is the plan of a test (kind: impact), not a rig file",
    "gap distinguishability rig.yaml rig.yaml": "describes a rig, no test",
    "gap history campaign.h5": "not text in UTF-8 but HDF5",
    "gap blind --out b --folder nowhere": "nowhere: is no folder",
    "export empty --run one --format csv --out x": "empty: is no data folder",
    "serve --data notes.txt": "notes.txt: is a file",
    "rig reset rig.yaml --data nowhere": "nowhere: is no folder",
    "identify campaign.h5 campaign.h5": "contains the same records as campaign.h5",
    "import empty.csv --rig rig.yaml --out new.h5": "empty.csv",
    # Options that would have no effect, and files that are not what the newest commands take.
    "gap blind --out b --truth empty": "--truth has no effect without --folder",
    "gap blind --out b --workers 0": "--workers is '0'; allowed: a whole number from 1",
    "gap blind --out b --folder empty": "empty",
    "gap blind --out b --trials -5": "trials",
    "gap next campaign.h5 --diagnosis d.json --out both.h5": "--out has no effect without --run",
    "gap next campaign.h5 --diagnosis d.json --json both.json": "--json has no effect without --run",
    "gap next campaign.h5 --diagnosis d.json --run --out both.h5": "does not leave two explanations",
    "gap export d.json --rig rig.yaml --form uff --out t.uff --rate 2000": "--rate has no effect without --form npz",
    "gap export d.json --rig rig.yaml --form npz --out t.npz --records 4": "--records has no effect without --on",
    "gap export d.json --rig rig.yaml --form npz --out t.npz --on campaign.h5 --records 0": "--records is '0'",
    "gap export d.json --rig rig.yaml --form npz --out t.mat": "a file of the form npz ends in .npz",
    "gap export d.json --rig rig.yaml --form mjcf --out t.mjcf": "a file of the form mjcf ends in .xml",
    "gap export d.json --rig plan_far.yaml --form npz --out t.npz": "is the plan of a test",
    "gap apply unknown.json --rig rig.yaml --out rig2.yaml": "no known effect",
    "gap apply d.json --rig campaign_rig.yaml --out rig2.yaml": "of ",
    "import analyser.mat --rig rig.yaml --map nowhere.yaml --out new.h5": "nowhere.yaml",
    "import analyser.mat --rig rig.yaml --map map_word.yaml --out new.h5": "map_word.yaml",
    "import analyser.mat --rig rig.yaml --map map_field.yaml --out new.h5": "freq",
    "identify --response-only campaign.h5": "--response-only is 'campaign.h5'; allowed: ssi_cov, plscf_spectra",
    "identify campaign.h5 --response-only --pick 20": "pick",
    # Units and forms in a plan or a rig file.
    "gap distinguishability rig.yaml plan_level.yaml": "levels_v.low is 'strong'; allowed: a number",
    "gap distinguishability rig.yaml plan_alone.yaml": "points is 10; allowed: a list, such as [10, 6]",
    "gap distinguishability rig.yaml plan_names.yaml": "points.0 is 'tip'; allowed: a whole number",
    "gap distinguishability rig.yaml plan_two.yaml": "write several tests as a list",
    "gap distinguishability rig.yaml plan_long.yaml": "write block_s in s",
    "gap distinguishability rig.yaml plan_loud.yaml": "low is 50 V; allowed by the rig: 5 V",
    "import table.csv --rig rig_mm.yaml --out new.h5": "777 mm is 0.777",
    "import table.csv --rig rig_gpa.yaml --out new.h5": "205 GPa is 2.05e11",
    # Drawn from the pages: a neighbour's file, an option alone, nobody at the terminal.
    "gap apply d.json --rig models.json --out rig2.yaml": "models.json: holds modal models, not a rig file",
    "gap history d.json": "d.json: is the diagnosis of a gap, not a rig file",
    "gap diagnose campaign.h5 --diagnosis d.json": "--diagnosis has no effect without --simulation",
    "gap diagnose campaign.h5 --simulation campaign_2.h5": "is a campaign, not predicted records",
    "gap diagnose campaign.h5 --simulation models.json": "models.json: is no HDF5 file",
    "gap predict campaign.h5 --out p.h5": "--diagnosis, --on are missing",
    "identify campaign.h5 --order 0": "order 0 holds no mode",
    "import page.html --rig rig.yaml --out new.h5": "page.html: ",
    "import campaign.h5 --rig rig.yaml --drive-point 99 --out new.h5": "99",
    "rig reset rig.yaml --data empty": "empty: is no data folder",
    "rig check rig_free.yaml --bench sim://cantilever --seconds 1 --drive 1": "the rig has no limits",
    "rig check rig.yaml --bench sim://cantilever --seconds 1 --drive 100": "allowed by limits.drive_v: above 0 to 5 V",
    "rig calibrate rig.yaml --bench sim://cantilever --channel a99 --method turnover": "has no channel 'a99'",
    "rig calibrate rig.yaml --bench sim://cantilever --channel a04 --method shunt": "needs --value",
    "rig calibrate rig.yaml --bench sim://cantilever --channel a04 --method turnover": "no terminal to press Enter",
    "campaign run --rig rig.yaml --plan plan_far.yaml --keys undo=b,pause=b": "one key for two",
    "campaign run --rig rig.yaml --plan rig.yaml --out x.h5": "describes a rig, no test",
    "backup empty --out b": "modallab serve and modallab campaign run make such a folder",
    "retention empty --older-than yesterday": "--older-than is 'yesterday'",
    "user remove Ada": "did you mean revoke?",
}


@pytest.mark.parametrize("command", MISTAKES)
def test_a_mistake_ends_in_one_sentence_and_a_remedy(command: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    # Nobody is there to press a key.
    monkeypatch.setattr("sys.stdin", io.StringIO())
    said = io.StringIO()
    with redirect_stdout(io.StringIO()), redirect_stderr(said):
        assert main(command.split()) == 2
    what, _, remedy = said.getvalue().partition("\n  what to do: ")
    assert what.startswith("modallab: ")
    assert MISTAKES[command] in what + remedy
    assert remedy.strip()
    assert not re.search(r"Traceback|pydantic|0x[0-9a-f]{6}", said.getvalue())


def test_a_path_may_hold_what_ascii_does_not(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    out = "grüße aus köln/messung ä.h5"
    with redirect_stdout(io.StringIO()):
        assert main(["import", "campaign.h5", "--rig", "campaign_rig.yaml", "--out", out, "--quiet"]) == 0
        assert main(["export", out, "--format", "uff", "--out", "grüße aus köln/ü.uff"]) == 0
    assert (here / "grüße aus köln" / "ü.uff").stat().st_size > 1000


def test_a_pattern_that_no_shell_has_expanded_is(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    with redirect_stdout(io.StringIO()):
        assert main(["import", "camp*.h5", "--rig", "campaign_rig.yaml", "--out", "pattern.h5", "--quiet"]) == 0


@pytest.mark.parametrize("asked", ["help", "added_mass,help"])
def test_effects_are_listed_where_one_is_asked_for(asked: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    said = io.StringIO()
    with redirect_stdout(said):
        assert main(["demo", "--effect", asked]) == 0
    assert "mass" in said.getvalue()
    assert not (here / "demo").exists()


def test_models_go_to_standard_output_alone(capsys: pytest.CaptureFixture[str], small: Path) -> None:
    assert main(["identify", str(small), "--test", "impact", "--json", "-"]) == 0
    printed = capsys.readouterr()
    assert [m["test"] for m in json.loads(printed.out)["models"]] == ["impact"]
    assert "Modal model" in printed.err


def test_a_band_may_begin_at_zero_and_nothing_is_said_where_nothing_is_asked_for(
    capsys: pytest.CaptureFixture[str], small: Path, tmp_path: Path
) -> None:
    from_zero = ["identify", str(small), "--test", "impact", "--band", "0", "110", "--quiet"]
    assert main([*from_zero, "--json", str(tmp_path / "m.json")]) == 0
    assert capsys.readouterr() == ("", "")
    (found,) = json.loads((tmp_path / "m.json").read_text())["models"]
    assert len(found["frequency_hz"]) == 3
    assert 0 <= found["band_hz"][0] < 3
