"""A fourth draw: forty files of loggers, analysers and scripts, written before any reader was run on them."""

from pathlib import Path

import h5py
import numpy as np
import scipy.io
from array_cases import wave, with_user_block
from clock_cases import at
from frf_cases import LINES, plain, polar
from frf_cases import save as save_frf
from known import RATE, VOLTS, G, Known, KnownFrf, Record, case, hit, inertance
from lvm_cases import head, segment
from lvm_cases import save as save_lvm
from sep005_cases import listed
from sep005_cases import save as save_sep
from tdms_cases import save as save_tdms
from tdms_cases import waved, whole
from text_cases import comma, save
from uff_cases import frfs, functions
from uff_cases import save as save_uff
from uff_written import EDGE, binary_58, text_58

NAMES = ("force", "a1", "a2")
HEAD = "time [s],force [N],a1 [m/s^2],a2 [m/s^2]"
NO_COLUMN = "no column|no channel"


def rows_of(record: Record, time=lambda i: f"{i / RATE:.6f}", between=",", factors=(1, 1, 1), digits=7):
    factors = np.array(factors)
    return [between.join([time(i), *(f"{v:.{digits}f}" for v in row * factors)]) for i, row in enumerate(record.rows.T)]


def german(rows: list[str]) -> list[str]:
    return [row.replace(".", ",") for row in rows]


@case("fourth")
def marked_and_german(folder: Path) -> Known:
    """Byte-order mark, CRLF, semicolons, decimal comma, g with a German heading of the time."""
    rows = german(rows_of(hit(), between=";", factors=(1, 1 / G, 1 / G), digits=9))
    return Known(
        save(folder, ["Zeit [s];force [N];a1 [g];a2 [g]", *rows], encoding="utf-8-sig", ending="\r\n"), (hit(),)
    )


@case("fourth")
def wide_text(folder: Path) -> Known:
    """UTF-16, little-endian with a mark, tabs, times in ms, units in a row of brackets."""
    rows = rows_of(hit(), lambda i: f"{1e3 * i / RATE:.3f}", "\t", (1e-3, 1, 1), 9)
    return Known(save(folder, ["Time\tforce\ta1\ta2", "[ms]\t[kN]\t[m/s²]\t[m/s²]", *rows], "utf-16"), (hit(),))


@case("fourth")
def minutes(folder: Path) -> Known:
    """Times in minutes."""
    rows = rows_of(hit(), lambda i: f"{i / RATE / 60:.12f}")
    return Known(save(folder, ["time [min],force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), (hit(),))


@case("fourth")
def hours_of_a_logger(folder: Path) -> Known:
    """Times in hours, `t (h)`."""
    rows = rows_of(hit(), lambda i: f"{12 + i / RATE / 3600:.14f}", ";")
    return Known(save(folder, ["t (h);force (N);a1 (m/s2);a2 (m/s2)", *rows]), (hit(),))


@case("fourth")
def days_of_a_spreadsheet(folder: Path) -> Known:
    """Serial days of a spreadsheet, 46110.4167..., twelve decimals, without a unit."""
    rows = rows_of(hit(), lambda i: f"{46110 + 10 / 24 + i / RATE / 86400:.12f}")
    return Known(save(folder, ["Time,force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), (hit(),), rejected="(?i)days|unit")


@case("fourth")
def days_with_unit(folder: Path) -> Known:
    """Days since a start, `time [d]`."""
    rows = rows_of(hit(), lambda i: f"{i / RATE / 86400:.14f}")
    return Known(save(folder, ["time [d],force [N],a1 [m/s^2],a2 [m/s^2]", *rows]), (hit(),))


@case("fourth")
def date_in_every_row(folder: Path) -> Known:
    """A date, a clock and then the channels, decimal points, semicolons."""
    rows = rows_of(hit(), lambda i: f"{at(i):%d.%m.%Y};{at(i):%H:%M:%S.%f}", ";")
    return Known(save(folder, ["Datum;Zeit;force [N];a1 [m/s^2];a2 [m/s^2]", *rows]), (hit(),))


@case("fourth")
def microseconds_as_whole_numbers(folder: Path) -> Known:
    """Times in µs as whole numbers."""
    rows = rows_of(hit(), lambda i: f"{i * 500}")
    return Known(save(folder, ["Time (µs),force (N),a1 (m/s²),a2 (m/s²)", *rows]), (hit(),))


@case("fourth")
def pipes(folder: Path) -> Known:
    """Columns between |, with blanks about them."""
    rows = rows_of(hit(), between=" | ")
    return Known(save(folder, [HEAD.replace(",", " | "), *rows]), (hit(),))


@case("fourth")
def french_thousands(folder: Path) -> Known:
    """Forces in mN with a narrow blank between thousands, and a decimal comma."""
    record = hit()
    group = lambda v: f"{v:,.3f}".replace(",", "\u202f").replace(".", ",")  # noqa: E731
    rows = [f"{comma(i / RATE)};{group(1e3 * f)};{comma(a)};{comma(b)}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, ["temps [s];force [mN];a1 [m/s^2];a2 [m/s^2]", *rows]), (record,))


@case("fourth")
def plain_blank_thousands(folder: Path) -> Known:
    """The same with an ordinary blank."""
    record = hit()
    group = lambda v: f"{v:,.3f}".replace(",", " ").replace(".", ",")  # noqa: E731
    rows = [f"{comma(i / RATE)};{group(1e3 * f)};{comma(a)};{comma(b)}" for i, (f, a, b) in enumerate(record.rows.T)]
    return Known(save(folder, ["time [s];force [mN];a1 [m/s^2];a2 [m/s^2]", *rows]), (record,))


@case("fourth")
def units_after_underscores(folder: Path) -> Known:
    """Names as scripts write them: time_s, force_N, a1_g, a2_g."""
    rows = rows_of(hit(), factors=(1, 1 / G, 1 / G), digits=9)
    return Known(save(folder, ["time_s,force_N,a1_g,a2_g", *rows]), (hit(),), rejected=NO_COLUMN)


@case("fourth")
def missing_at_the_end(folder: Path) -> Known:
    """The last five rows hold --- for the accelerations."""
    rows = rows_of(hit())
    rows[-5:] = [",".join([*row.split(",")[:2], "---", "---"]) for row in rows[-5:]]
    return Known(save(folder, [HEAD, *rows]), rejected="---")


@case("fourth")
def every_line_twice_ended(folder: Path) -> Known:
    """Every second line is empty, as CR CR LF gives it."""
    return Known(save(folder, [HEAD, *rows_of(hit())], ending="\r\r\n"), (hit(),))


@case("fourth")
def facts_in_front(folder: Path) -> Known:
    """Fifteen lines of facts, `Sample rate [Hz]:;2000`, then names, units, and numbers with decimal commas."""
    facts = [f"Fact {k}:;{k},5" for k in range(14)] + ["Sample rate [Hz]:;2000"]
    rows = german(rows_of(hit(), between=";"))
    return Known(save(folder, [*facts, "", "time;force;a1;a2", "s;N;m/s²;m/s²", *rows]), (hit(),))


@case("fourth")
def oscilloscope_start_and_step(folder: Path) -> Known:
    """Sequence numbers, and start and increment in the header: X,CH1,CH2,CH3,Start,Increment."""
    record = hit()
    rows = [f"{i},{f:.6f},{a:.6f},{b:.6f}," for i, (f, a, b) in enumerate(record.rows.T)]
    head = ["X,force,a1,a2,Start,Increment", "Sequence,N,m/s^2,m/s^2,-1.000000e-02,5.000000e-04"]
    return Known(save(folder, [*head, *rows]), (record,), rejected="(?i)column|time|unit")


@case("fourth")
def fortran_exponents(folder: Path) -> Known:
    """Columns of width with D exponents and comment lines with !."""
    record = hit()
    rows = ["".join(f"{v:17.9E}".replace("E", "D") for v in (i / RATE, *row)) for i, row in enumerate(record.rows.T)]
    return Known(save(folder, ["! a program", "# time force a1 a2", *rows], name="case.dat"), (record,))


@case("fourth")
def two_measurements_below_each_other(folder: Path) -> Known:
    """Two hits in one file, each with its header and an empty line before it."""
    parts = [line for k in (1, 2) for line in ("", f"Measurement {k}", HEAD, *rows_of(hit(k)))]
    return Known(save(folder, parts), (hit(1), hit(2)))


@case("fourth")
def statistics_at_the_end(folder: Path) -> Known:
    """Three lines below the table: Max, Min, RMS."""
    below = ["", "Max,100,20,30", "Min,-1,-20,-30", "RMS,5,3,4"]
    return Known(save(folder, [HEAD, *rows_of(hit()), *below]), (hit(),), rejected="Max")


@case("fourth")
def millivolts(folder: Path) -> Known:
    """Everything in mV, sensitivities in the rig."""
    record = hit()
    head = "time [s],force [mV],a1 [mV],a2 [mV]"
    return Known(save(folder, [head, *rows_of(record, factors=(10, 10, 10))]), (record,), rig=VOLTS)


@case("fourth")
def swept_down_in_decibels(folder: Path) -> Known:
    """Lines falling and logarithmic, levels in dB, degrees."""
    f = np.geomspace(220, 20, 500)
    h = inertance(f)[:, 0]
    (m1, p1), (m2, p2) = (polar(row) for row in h)
    head = "Freq (Hz)\ta1 Mag (dB)\ta1 Phase (deg)\ta2 Mag (dB)\ta2 Phase (deg)"
    right = KnownFrf(f[::-1], h[:, ::-1])
    return Known(save_frf(folder, [head], [f, 20 * np.log10(m1), p1, 20 * np.log10(m2), p2], "\t"), frf=right)


@case("fourth")
def coherence_in_percent(folder: Path) -> Known:
    """Coherences in %, real and imaginary parts in g/N."""
    right, c = plain(), 100 - np.exp(-LINES / 100)
    (x, y) = right.values / G
    head = "f [Hz];Re a1 [g/N];Im a1 [g/N];Coherence a1 [%];Re a2 [g/N];Im a2 [g/N];Coherence a2 [%]"
    known = KnownFrf(LINES, right.values, coherence=np.array([c, c]) / 100)
    return Known(save_frf(folder, [head], [LINES, x.real, x.imag, c, y.real, y.imag, c], ";"), frf=known)


@case("fourth")
def coherence_in_percent_without_unit(folder: Path) -> Known:
    """The same without the unit: numbers near 100 are no coherence in one."""
    right, c = plain(), 100 - np.exp(-LINES / 100)
    (x, y) = right.values
    head = "f [Hz];Re a1;Im a1;Coherence a1;Re a2;Im a2;Coherence a2"
    known = KnownFrf(LINES, right.values, coherence=np.array([c, c]) / 100)
    files = save_frf(folder, [head], [LINES, x.real, x.imag, c, y.real, y.imag, c], ";")
    return Known(files, frf=known, rejected="(?i)coherence")


@case("fourth")
def per_pound_force(folder: Path) -> Known:
    """Real and imaginary in g/lbf, frequencies in kHz."""
    right = plain()
    (x, y) = right.values / G * 4.4482216152605
    head = "Frequency [kHz],a1 Real [g/lbf],a1 Imaginary [g/lbf],a2 Real [g/lbf],a2 Imaginary [g/lbf]"
    return Known(save_frf(folder, [head], [LINES / 1e3, x.real, x.imag, y.real, y.imag]), frf=right)


@case("fourth")
def millimetres_per_newton(folder: Path) -> Known:
    """Modulus in (mm/s²)/N, argument in rad, decimal comma."""
    right = plain()
    (m1, p1), (m2, p2) = (polar(h, False) for h in right.values)
    head = "Fréquence [Hz];Module a1 [(mm/s²)/N];Phase a1 [rad];Module a2 [(mm/s²)/N];Phase a2 [rad]"
    return Known(save_frf(folder, [head], [LINES, 1e3 * m1, p1, 1e3 * m2, p2], ";", ","), frf=right)


@case("fourth")
def imaginary_in_the_end(folder: Path) -> Known:
    """MATLAB's writematrix: complex numbers `1.2-3.4i`."""
    right = plain()
    rows = [
        f"{f:g}," + ",".join(f"{v.real:.10g}{v.imag:+.10g}i" for v in h)
        for f, h in zip(LINES, right.values.T, strict=True)
    ]
    return Known(save(folder, ["f_Hz,a1,a2", *rows]), frf=right)


@case("fourth")
def frfs_below_each_other(folder: Path) -> Known:
    """An analyser's two functions below each other, each with its tags, then frequency, real, imaginary."""
    right, lines = plain(), []
    for name, h in zip(("a1", "a2"), right.values, strict=True):
        lines += [f"Function:\tFRF {name}/force", "Unit:\tm/s²/N", "Frequency [Hz]\tReal\tImag"]
        lines += [f"{f:g}\t{v.real:.8g}\t{v.imag:.8g}" for f, v in zip(LINES, h, strict=True)] + [""]
    return Known(save(folder, lines, name="case.txt"), frf=right, rejected="(?i)header|several|tables|response")


@case("fourth")
def lvm_comma_multi(folder: Path) -> Known:
    """LabVIEW with commas between columns and an X column a channel; kN and g."""
    record = hit()
    rows = [record.force / 1e3, record.a1 / G, record.a2 / G]
    text = head(",", "Multi") + segment(rows, "Multi", ",", units=("kN", "g", "g"))
    return Known(save_lvm(folder, text), (record,))


@case("fourth")
def lvm_hits_of_two_rates(folder: Path) -> Known:
    """Two segments, the second at half the rate."""
    one, two = hit(1), hit(2, rate=RATE / 2)
    text = head(multi="Yes") + segment(list(one.rows)) + segment(list(two.rows), delta=(2 / RATE,) * 3)
    return Known(save_lvm(folder, text), (one, two), rejected="(?i)rate|Hz")


@case("fourth")
def tdms_millivolts_of_floats(folder: Path) -> Known:
    """TDMS in single precision, mV, sensitivities in the rig."""
    record = hit()
    props = [p | {"unit_string": "mV"} for p in waved()]
    return Known(save_tdms(folder, whole([(10 * r).astype("f4") for r in record.rows], props)), (record,), rig=VOLTS)


@case("fourth")
def tdms_before_zero(folder: Path) -> Known:
    """TDMS whose offset is negative: 60 samples before the trigger; kN."""
    record = hit()
    props = [p | {"wf_start_offset": -60 / RATE, "wf_xname": "Time"} for p in waved()]
    props[0] |= {"unit_string": "kN"}
    return Known(save_tdms(folder, whole([record.force / 1e3, record.a1, record.a2], props)), (record,))


@case("fourth")
def wav_32_bit_whole(folder: Path) -> Known:
    """Whole numbers of 32 bits without any scale: numbers without a unit."""
    record = hit()
    top = np.abs(record.rows).max() * 1.1
    data = np.round(record.rows.T / top * (2**31 - 1)).astype("<i4").tobytes()
    (folder / "case.wav").write_bytes(wave(data, 1, 32))
    shares = Record(*(record.rows / top))
    return Known(("case.wav",), (shares,), says="(?i)full scale")


@case("fourth")
def uff_among_other_datasets(folder: Path) -> Known:
    """Datasets 1858, 2420 and 780 between the records."""
    record = hit()
    other = [EDGE, "  1858", *(f"{k:12d}{0:12d}" for k in range(8)), EDGE, EDGE, "  2420", "         1", "case", EDGE]
    parts = text_58(functions(record))
    return Known(save_uff(folder, other + parts + other), (record,))


@case("fourth")
def uff_before_the_trigger(folder: Path) -> Known:
    """Records whose abscissa begins at -0.03 s."""
    return Known(save_uff(folder, text_58(functions(hit(), first=-0.03, double=True))), (hit(),))


@case("fourth")
def uff_binary_frfs_in_g(folder: Path) -> Known:
    """58b, FRFs in g/N by the labels, double precision."""
    right = plain()
    (folder / "case.uff").write_bytes(b"".join(binary_58(f) for f in frfs(right.values / G, unit="g", double=True)))
    return Known(("case.uff",), frf=right)


@case("fourth")
def matlab_step_in_a_structure(folder: Path) -> Known:
    """A structure with dt and a matrix of columns, and the names in a cell."""
    record = hit()
    names = np.array(NAMES, dtype=object)
    data = {"dt": 1 / RATE, "values": record.rows.T, "names": names}
    scipy.io.savemat(folder / "case.mat", {"rec": data})
    return Known(("case.mat",), (record,), rejected="(?i)map|channel|array")


@case("fourth")
def matlab_fields_and_step(folder: Path) -> Known:
    """A structure with dt, and a field a channel."""
    record = hit()
    content = {"dt": 1 / RATE} | {n: r[:, None] for n, r in zip(NAMES, record.rows, strict=True)}
    scipy.io.savemat(folder / "case.mat", {"data": content})
    return Known(("case.mat",), (record,))


@case("fourth")
def matlab_of_an_analyser(folder: Path) -> Known:
    """A structure a signal: x_values.increment, y_values.values and its unit, function_record.name."""
    record = hit()
    signals = {
        f"Signal_{k}": {
            "x_values": {"start_value": 0.0, "increment": 1 / RATE, "number_of_values": row.size},
            "y_values": {"values": row[:, None], "quantity": {"label": unit}},
            "function_record": {"name": name, "type": "Time"},
        }
        for k, (row, name, unit) in enumerate(zip(record.rows, NAMES, ("N", "m/s^2", "m/s^2"), strict=True))
    }
    scipy.io.savemat(folder / "case.mat", signals)
    return Known(("case.mat",), (record,), rejected="(?i)channel|map|variable|array")


@case("fourth")
def matlab_73_variables(folder: Path) -> Known:
    """Version 7.3: force, a1, a2 as rows, Fs beside them."""
    record = hit()
    with h5py.File(folder / "body.h5", "w", userblock_size=512) as file:
        for name, row in [*zip(NAMES, record.rows, strict=True), ("Fs", np.array([RATE]))]:
            file[name] = row[:, None]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    (folder / "case.mat").write_bytes(with_user_block(folder / "body.h5"))
    return Known(("case.mat",), (record,))


@case("fourth")
def numpy_with_named_fields(folder: Path) -> Known:
    """A structured array: time, force, a1, a2."""
    record = hit()
    values = np.zeros(len(record.force), [(n, "f8") for n in ("time", *NAMES)])
    for name, row in zip(("time", *NAMES), [record.time, *record.rows], strict=True):
        values[name] = row
    np.save(folder / "case.npy", values)
    return Known(("case.npy",), (record,), rejected="(?i)field|structured|columns|numbers")


@case("fourth")
def sep_in_other_units(folder: Path) -> Known:
    """SEP005 in kN and g, data as columns of one (n, 1)."""
    record = hit()
    series = listed([record.force / 1e3, record.a1 / G, record.a2 / G], ("kN", "g", "g"))
    for one in series:
        one["data"] = [[v] for v in one["data"]]
    return Known(save_sep(folder, series), (record,))
