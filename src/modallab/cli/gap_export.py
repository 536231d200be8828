"""`modallab gap export`: the corrected simulation, where its users simulate."""

import argparse

from modallab.cli.console import console_of, write_json
from modallab.cli.gap import read_diagnosis
from modallab.cli.options import require_option
from modallab.core.digits import share_text, three_digits
from modallab.core.errors import PlanError
from modallab.core.progress import report_progress_to
from modallab.core.units import Test
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.gap.export.forms import FORMS, FormError, measure_form, tests_of, write_form

STEPPED = ("npz", "mat")
"""Forms that can hold the system in steps of time."""


def run(arguments: argparse.Namespace) -> int:
    """Write the twin of a diagnosis in a form; with a campaign, measure it in that form."""
    if arguments.form not in STEPPED:
        require_option("--form npz or mat", rate=arguments.rate)
    if arguments.on is None:
        require_option("--on", records=arguments.records, json=arguments.json)
    form, rig = FORMS[arguments.form], read_rig(arguments.rig)
    diagnosis = read_diagnosis(arguments.diagnosis)
    if arguments.out.suffix != form.suffix:
        raise PlanError(f"a file of the form {form.name} ends in {form.suffix}", remedy=f"name it ...{form.suffix}")
    tests: list[Test] = [arguments.test] if arguments.test else tests_of(rig)
    tests = tests[:1] if form.one_test else tests
    # Before anything is written: who mistypes the campaign is left with no file.
    campaign = None if arguments.on is None else read_campaign(arguments.on, rig)
    write_form(arguments.out, form, diagnosis, rig, tests, arguments.rate)
    console = console_of(arguments)
    console.print(f"{form.says}, {' and '.join(tests)}: {arguments.out}", markup=False, soft_wrap=True)
    if campaign is None:
        return 0
    with console.status("playing the records") as status, report_progress_to(lambda _, words: status.update(words)):
        found = measure_form(form, diagnosis, campaign, tests, arguments.records)
    console.print(form_in_words(found), markup=False, soft_wrap=True)
    if arguments.json is not None:
        write_json(arguments.json, found.model_dump(mode="json"))
    return 0


def form_in_words(found: FormError) -> str:
    """How far the form is from the bench, in one sentence."""
    share = "" if found.closed is None else f", {share_text(found.closed)} closed"
    return (
        f"In this form the gap is {three_digits(found.before)} noise units before and "
        f"{three_digits(found.after)} after{share}; "
        f"that of the twin itself is {three_digits(found.twin_after)}. On {len(found.records)} records."
    )
