"""Surfaces from files: texts, tables and arrays by themselves, makers' formats by the extra; and what is no surface."""

import csv
import io
import json
import os
import struct
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import MissingExtraError

MEASURED = Path(__file__).parent.parent.parent / "shared" / "data" / "topography"
HEIGHTS = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.5]])
HEAD = "# Channel: Topo\n# Width: 3 um\n# Height: 2 um\n# Value units: nm\n"
SURFACE = mdr.Topography(1e-9 * HEIGHTS.T, ["3 um", "2 um"])


def same(computed, expected=SURFACE):
    assert computed.heights == pytest.approx(expected.heights, rel=1e-12, nan_ok=True)
    assert computed.size == pytest.approx(expected.size, rel=1e-12)
    return True


@pytest.fixture
def without_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)


@pytest.mark.parametrize("between", [",", ";", "\t", " ", "  ", ", "])
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_texts(tmp_path, between, ending):
    rows = "\n".join(between.join(f"{z:g}" for z in row) for row in HEIGHTS)
    file = tmp_path / "surface.txt"
    file.write_bytes((HEAD + rows + "\n").replace("\n", ending).encode())
    result = mdr.read_topography(file)
    assert same(result)
    assert result.steps == ("read from surface.txt",)
    file.write_bytes((rows + "\n").replace("\n", ending).encode())
    assert same(mdr.read_topography(str(file), size=["3 um", "2 um"], unit="nm"))
    assert same(mdr.read_topography(file, 0, size=[3e-6, 2e-6], unit="nm"))


@settings(max_examples=examples(25), deadline=None)
@given(
    st.integers(2, 6),
    st.integers(2, 6),
    st.integers(0, 99),
    st.sampled_from(["nm", "um", "m", "Å"]),
    st.booleans(),
)
def test_there_and_back(tmp_path_factory, nx, ny, seed, unit, shuffled):
    rng = np.random.default_rng(seed)
    heights = rng.standard_normal((nx, ny)) * 1e-9
    surface = mdr.Topography(heights, [nx * 2e-7, ny * 3e-7])
    folder = tmp_path_factory.mktemp("surface")
    factor = mdr.Topography([[f"1 {unit}"] * 2] * 2, 1.0).heights[0, 0]
    with (folder / "a.csv").open("w", encoding="utf-8") as handle:
        handle.write(f"# Width: {nx * 0.2!r} um\n# Height: {ny * 0.3!r} um\n# Value units: {unit}\n")
        csv.writer(handle).writerows((heights / factor).T.tolist())
    assert same(mdr.read_topography(folder / "a.csv"), surface)
    x, y = np.meshgrid(surface.x, surface.y, indexing="ij")
    rows = np.array([x.ravel(), y.ravel(), heights.ravel() / factor]).T
    if shuffled:
        rng.shuffle(rows)
    header = f"x [m],y [m],z [{unit}]"
    np.savetxt(
        folder / "b.csv", rows, delimiter=",", header=header, comments="", fmt="%.17g", encoding="utf-8"
    )
    assert same(mdr.read_topography(folder / "b.csv"), surface)
    np.save(folder / "c.npy", heights / factor)
    assert same(mdr.read_topography(folder / "c.npy", size=surface.size, unit=unit), surface)


def test_what_is_missing_and_the_trend(tmp_path):
    file = tmp_path / "surface.csv"
    heights = np.add.outer(np.arange(8.0), 2.0 * np.arange(6.0))
    heights[3, 2] = np.nan
    file.write_text(
        "# Width: 6 nm\n# Height: 8 nm\n# Value units: nm\n"
        + "\n".join(",".join(map(str, row)) for row in heights)
    )
    with pytest.raises(
        mdr.CaseError,
        match=r"1 of 48 heights are missing; give missing: 'interpolate', 'crop' or 'keep'",
    ):
        mdr.read_topography(file)
    kept = mdr.read_topography(file, missing="keep")
    assert kept.missing.sum() == 1
    filled = mdr.read_topography(file, missing="interpolate", detrend="plane")
    assert np.max(np.abs(filled.heights)) < 1e-20
    assert [step.split(",")[0] for step in filled.steps] == [
        "read from surface.csv",
        "1 of 48 heights were missing (2.1 %)",
        "a plane subtracted",
    ]
    assert mdr.read_topography(file, missing="crop").heights.shape == (6, 4)
    for wrong in ({"missing": "guess"}, {"detrend": "cubic"}):
        with pytest.raises(mdr.CaseError, match="is needed"):
            mdr.read_topography(file, **wrong)
    # places that a table leaves out
    table = tmp_path / "table.csv"
    table.write_text("x [um];y [um];z [nm]\n0;0;1\n1;0;2\n0;1;3\n2;0;1\n1;1;5\n")
    assert mdr.read_topography(table, missing="keep").missing.tolist() == [
        [False, False],
        [False, False],
        [False, True],
    ]


ROWS = "0 1 2\n3 4 5\n"


@pytest.mark.parametrize("extra", [False, True])
@pytest.mark.parametrize(
    ("text", "arguments", "words"),
    [
        (ROWS, {"size": "1 um"}, "no unit of the heights; give size= and unit="),
        (ROWS, {"unit": "nm"}, "no sides of the patch; give size= and unit="),
        (HEAD + ROWS, {"unit": "nm"}, "the file says 'nm'; leave it out"),
        (HEAD + ROWS, {"size": "1 um"}, "the file says 3 µm x 2 µm; leave it out"),
        (HEAD.replace("nm", "V") + ROWS, {}, "does not fit"),
        (HEAD.replace("nm", "furlongs per fortnight") + ROWS, {}, "unit"),
        (HEAD.replace("3 um", "3") + ROWS, {}, "Width"),
        (HEAD.replace("3 um", "-3 um") + ROWS, {}, "above 0 m"),
        (ROWS, {"size": "1 um", "unit": 5}, "a text such as 'nm'"),
        (ROWS, {"size": "1 um", "unit": "N"}, "does not fit"),
        (HEAD + "0 1 2\n", {}, "at least 2 x 2"),
        (HEAD + "0\n1\n2\n", {}, "at least 2 x 2"),
        (HEAD + "0 1 2\n3 4\n", {}, "line 6: 2 heights for 3"),
        (HEAD + "0 1 2\n3 4 x\n", {}, "line 6: 'x' is not a number"),
        (HEAD + "0,5;1.5\n1,0;2,0\n", {}, "decimals written with a point"),
        (HEAD + "1,500;2,500\n1,000;3,000\n", {}, "decimals written with a point"),
        ("0 1\n1 2\n2 1\n", {"size": "1 um", "unit": "nm"}, "two columns (x and z) of 3 rows: a line scan"),
        ("1\n2\n3\n", {"size": "1 um", "unit": "nm"}, "one column of 3 rows: a line scan"),
        ("0 0 1\n0 2 1\n1 0 3\n1 2 1\n", {"size": "1 um", "unit": "nm"}, "write 'x [um], y [um], z [nm]'"),
        (HEAD + "0 1\n2 inf\n", {}, "not finite"),
        (HEAD + "nan nan\nnan nan\n", {}, "all heights are missing"),
        (HEAD, {}, "no heights"),
        ("", {}, "no heights"),
        ("Dear reader,\nthis is a letter.\n", {}, "is not a number"),
        (HEAD + ROWS + HEAD + ROWS, {}, "line 7: a second header"),
        (HEAD + ROWS, {"channel": "Topo"}, "one surface only"),
        (HEAD + ROWS, {"channel": 1}, "one surface only"),
        (
            "x [um], y [um], z [nm]\n0,0,1\n1,0,2\n3,0,1\n0,1,3\n1,1,1\n3,1,4\n",
            {},
            "x is not on an even grid",
        ),
        (
            "x [um], y [um], z [nm]\n0,0,1\n1,0,2\n2,0,2\n",
            {},
            "y is 0 m everywhere: one row is not a surface",
        ),
        ("x [um], y [um], z [nm]\n0,0,1\n1,0,2\n0,1,2\n1,1,2\n1,1,3\n", {}, "has several heights"),
        ("x [um], y [um], z [nm]\n" + "".join(f"{i},{i},0\n" for i in range(20)), {}, "scattered"),
        ("x [um], y [um], z\n0,0,1\n1,0,2\n", {}, "has no unit"),
        ("x [um], z [nm]\n0,1\n1,2\n", {}, "no column of y"),
        ("x [um], z [nm]\n0,1\n1,2\n", {}, "a line scan or a profile, not a surface"),
        ("r [nm], f [nm], scatter [nm], points\n0,0,0,1\n1,2,0,1\n", {}, "for read_profile"),
    ],
)
def test_texts_that_are_no_surface(tmp_path, monkeypatch, text, arguments, words, extra):
    if extra:
        of_makers()
    else:
        monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    if extra and "second header" in words:
        pytest.skip("the extra reads the first of several surfaces")
    file = tmp_path / "surface.txt"
    file.write_text(text, encoding="utf-8")
    with pytest.raises((mdr.CaseError, mdr.UnitError)) as refusal:
        mdr.read_topography(file, **arguments)
    assert words in str(refusal.value)
    assert str(refusal.value).count("surface.txt") == 1
    assert "\n" not in str(refusal.value)


@settings(max_examples=examples(25), deadline=None)
@given(
    st.integers(2, 5),
    st.integers(4, 6),
    st.integers(0, 99),
    st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"]),
    st.sampled_from([";", "\t", " "]),
    st.sampled_from([".csv", ".dat", ".001", ""]),
    st.booleans(),
)
def test_texts_of_other_places(tmp_path_factory, nx, ny, seed, encoding, between, suffix, commas):
    """Encodings, decimal commas and suffixes change nothing."""
    heights = np.random.default_rng(seed).standard_normal((nx, ny))
    rows = "\n".join(between.join(repr(float(z)) for z in row) for row in heights.T)
    x, y = ((np.arange(n) + 0.5) * 0.25 for n in (nx, ny))
    table = "\n".join(
        ";".join(repr(float(v)) for v in (x[i], y[j], heights[i, j])) for i in range(nx) for j in range(ny)
    )
    if commas:
        rows, table = rows.replace(".", ","), table.replace(".", ",")
    folder = tmp_path_factory.mktemp("surface")
    expected = mdr.Topography(1e-6 * heights, [nx * 0.25e-6, ny * 0.25e-6])
    head = f"# Width: {nx * 0.25} \u00b5m\n# Height: {ny * 0.25} \u00b5m\n# Value units: \u00b5m\n"
    for text in (head + rows, "x [\u00b5m]; y [\u00b5m]; z [\u00b5m]\n" + table):
        (folder / f"surface{suffix}").write_bytes(text.encode(encoding))
        assert same(mdr.read_topography(folder / f"surface{suffix}"), expected)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x1f\x8b\x08", "compressed by gzip; unpack it"),
        (b"\x89PNG\r\n\x1a\n\0", "a picture (PNG); colours are not heights"),
        (("a.csv", "b.sur", "meta.yml"), "an archive (zip) of 3 files: a.csv, b.sur, meta.yml; unpack it"),
        (tuple(f"{i}.di" for i in range(9)), "9 files: 0.di, 1.di, 2.di, 3.di, 4.di and 4 more; unpack it"),
        (("header.properties", "segments/0/channels/height.dat"), "read them with read_curves"),
    ],
)
@pytest.mark.parametrize("suffix", [".zip", ".dat", ".csv"])
def test_containers(tmp_path, monkeypatch, content, words, suffix):
    file = tmp_path / f"packed{suffix}"
    if isinstance(content, bytes):
        file.write_bytes(content)
    else:
        with zipfile.ZipFile(file, "w") as archive:
            for name in content:
                archive.writestr(name, "1 2\n3 4\n")
    # what it is does not depend on what is installed
    with pytest.raises(mdr.CaseError) as refusal:
        mdr.read_topography(file)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    with pytest.raises(mdr.CaseError) as bare:
        mdr.read_topography(file)
    assert words in str(refusal.value)
    assert str(refusal.value) == str(bare.value)


@pytest.mark.usefixtures("without_extra")
def test_files_that_are_no_surface(tmp_path):
    empty = tmp_path / "nothing.npy"
    for content in (b"", b"\x93NUMPY", b"PK\x03\x04", b"garbage"):
        empty.write_bytes(content)
        with pytest.raises(mdr.CaseError, match="not an array of NumPy"):
            mdr.read_topography(empty, size=1.0, unit="m")
    for array in (np.array([["a", "b"]] * 2), np.ones((2, 2), dtype=complex)):
        np.save(empty, array)
        with pytest.raises(mdr.CaseError, match="array of real numbers"):
            mdr.read_topography(empty, size=1.0, unit="m")
    buffer = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        buffer, {"descr": "<f8", "fortran_order": False, "shape": (1 << 40, 1 << 10)}
    )
    empty.write_bytes(buffer.getvalue())
    with pytest.raises(mdr.CaseError, match="not an array of NumPy"):
        mdr.read_topography(empty, size=1.0, unit="m")
    (tmp_path / "none.opd").write_bytes(b"")
    with pytest.raises(mdr.CaseError, match="the file is empty"):
        mdr.read_topography(tmp_path / "none.opd")
    with pytest.raises(mdr.FileError, match="cannot read"):
        mdr.read_topography(tmp_path / "absent.csv")
    with pytest.raises(mdr.FileError, match="regular file"):
        mdr.read_topography(tmp_path)
    with pytest.raises(mdr.FileError, match="name of a file"):
        mdr.read_topography(None)
    (tmp_path / "scan.di").write_bytes(b"\x00")
    with pytest.raises(MissingExtraError, match=r"pip install 'pymdr\[topography\]'"):
        mdr.read_topography(tmp_path / "scan.di")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
def test_a_pipe_does_not_hold_the_program(tmp_path):
    os.mkfifo(tmp_path / "pipe.npy")
    with pytest.raises(mdr.FileError, match="regular file"):
        mdr.read_topography(tmp_path / "pipe.npy")


def of_makers(name=None):
    pytest.importorskip(
        "SurfaceTopography", reason="SurfaceTopography, of the extra topography, is not installed"
    )
    if name is not None and not (MEASURED / name).exists():
        pytest.skip(f"{name}, from the tests of SurfaceTopography, is not beside the repository")
    return MEASURED / str(name)


def test_damaged_files_of_makers(tmp_path):
    of_makers()
    with zipfile.ZipFile(tmp_path / "nothing.x3p", "w"):
        pass
    (tmp_path / "zeros.di").write_bytes(bytes(1000))
    for name in ("nothing.x3p", "zeros.di"):
        with pytest.raises(mdr.FileError, match=f"cannot read .*{name}"):
            mdr.read_topography(tmp_path / name)


def _as_german(heights):
    head = "# Kanal: A\n# Breite: 4 \u00b5m\n# H\u00f6he: 2 \u00b5m\n# Einheiten: nm\n"
    return (head + "\n".join(" ".join(map(str, row)) for row in heights)).encode()


def _as_spip(heights):
    head = "# File Format = ASCII\n# x-pixels = 4\n# y-pixels = 2\n# x-length = 4000\n# y-length = 2000\n"
    units = "# x-unit = nm\n# y-unit = nm\n# z-unit = nm\n"
    return (head + units + "\n".join("\t".join(map(str, row)) for row in heights)).encode()


def _as_sdf(heights):
    words = "aISO-1.0\nManufacID = A\nCreateDate = 040120100853\nModDate = 050320101353\nNumPoints = 4\nNumProfiles = 2\n"
    scales = "Xscale = 1e-6\nYscale = 1e-6\nZscale = 1e-9\nZresolution = 1e-12\n"
    kinds = "Compression = 0\nDataType = 7\nCheckType = 0\n*\n"
    return (words + scales + kinds + "\n".join(" ".join(map(str, row)) for row in heights) + "\n*\n").encode()


def _as_metropro(heights):
    """Format 1 of Zygo: a header of 834 bytes, big endian; heights in steps of wavelength * scale / 4096."""
    content = bytearray(834)
    for place, kind, value in (
        (0, ">I", 0x881B036F),
        (4, ">h", 1),
        (6, ">i", 834),
        (68, ">h", 4),
        (70, ">h", 2),
        (72, ">i", 32),
        (164, ">f", 0.5),
        (168, ">f", 4096e-9),
        (176, ">f", 1.0),
        (184, ">f", 1e-6),
    ):
        struct.pack_into(kind, content, place, value)
    return bytes(content) + (2.0 * heights).astype(">i4").tobytes()


@pytest.mark.parametrize("suffix", [".dat", ".csv", ".txt", ".sdf", ".xyz", ""])
@pytest.mark.parametrize("made", [_as_german, _as_spip, _as_sdf, _as_metropro])
def test_formats_whatever_their_suffix(tmp_path, made, suffix):
    of_makers()
    file = tmp_path / f"surface{suffix}"
    rows = np.array([[0.0, 1.0, 2.0, 4.0], [3.0, 4.0, 5.5, 9.0]])
    file.write_bytes(made(rows))
    result = mdr.read_topography(file)
    assert result.size == pytest.approx([4e-6, 2e-6])
    assert result.heights == pytest.approx(1e-9 * rows.T, rel=1e-6)


def test_a_measured_surface_whatever_its_suffix(tmp_path):
    expected = mdr.read_topography(of_makers("stp-1.stp"))
    (tmp_path / "surface.csv").write_bytes((MEASURED / "stp-1.stp").read_bytes())
    assert same(mdr.read_topography(tmp_path / "surface.csv"), expected)


def test_a_format_known_by_its_suffix_alone(tmp_path):
    """NanoFocus, whose header begins as an empty matrix of MATLAB does."""
    of_makers()
    heights = np.random.default_rng(3).integers(0, 2**16 - 1, (5, 7)).astype("<u2")
    header = bytearray(3468)
    header[:16] = bytes([2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 255, 255, 0, 0])
    struct.pack_into("<2d", header, 16, 1.0, 3.0)
    struct.pack_into("<2I2d", header, 1368, 7, 5, 2e-3, 4e-3)
    file = tmp_path / "surface.nms"
    file.write_bytes(bytes(header) + heights.tobytes())
    surface = mdr.read_topography(file)
    assert surface.size == pytest.approx([14e-6, 20e-6])
    assert surface.heights == pytest.approx(1e-6 * (1.0 + 2.0 * heights.T / (2**16 - 2)))


@pytest.mark.parametrize("name", ["dektak-1.csv", "xy-1.txt"])
def test_measured_lines(name):
    with pytest.raises(mdr.CaseError, match=r"a line scan.*, not a surface\. Of one bump .*read_profile"):
        mdr.read_topography(of_makers(name))


@pytest.mark.parametrize(
    ("name", "shape", "size", "rms", "options"),
    [
        ("di-1.di", (512, 512), [500e-9, 500e-9], 9.945986800560389e-9, {"channel": 0}),
        ("mi-1.mi", (256, 256), [20e-6, 20e-6], 33.215426493512654e-9, {}),
        ("stp-1.stp", (256, 256), [600e-9, 600e-9], 1.6541593884416916e-9, {}),
        (
            "metropro-1.dat",
            (640, 480),
            [0.0007028812979115173, 0.000527160973433638],
            7.528822204734589e-08,
            {},
        ),
        ("frt-2.frt", (150, 300), [0.03, 0.06], 8.826763181113768e-06, {"missing": "keep"}),
    ],
)
def test_measured_surfaces(name, shape, size, rms, options):
    surface = mdr.read_topography(of_makers(name), **options)
    assert surface.heights.shape == shape
    assert surface.size == pytest.approx(size, rel=1e-9)
    # by SurfaceTopography 1.27
    assert np.nanstd(surface.heights) == pytest.approx(rms, rel=1e-9)
    assert surface.steps[0].startswith(f"read from {name}, channel 0")


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        (
            "di-1.di",
            {"channel": 2},
            "'Phase' holds no heights; channels with heights are 0 'Height', 1 'Height'",
        ),
        ("di-1.di", {"channel": "Height"}, "2 channels 'Height'"),
        ("di-1.di", {"channel": 9}, "no channel 9; the file has 0 'Height'"),
        ("mi-1.mi", {"channel": "Deflection"}, "holds no heights"),
        ("mi-1.mi", {"size": "1 um"}, "leave it out"),
        ("mi-1.mi", {"unit": "nm"}, "leave it out"),
        ("frt-2.frt", {}, "12314 of 45000 heights are missing"),
    ],
)
def test_channels_that_are_no_surface(name, options, words):
    with pytest.raises(mdr.CaseError) as refusal:
        mdr.read_topography(of_makers(name), **options)
    assert words in str(refusal.value)


def test_the_spectrum_of_a_measured_surface():
    surface = mdr.read_topography(of_makers("mi-1.mi"), detrend="plane")
    spectrum = mdr.power_spectrum(surface, tip_radius="10 nm")
    assert 0.5 < spectrum.fit.hurst < 0.9
    assert not spectrum.assumptions[0].met  # terraces lie one way
    assert "read from mi-1.mi" in str(spectrum)
    with pytest.raises(mdr.ProblemError, match="not one bump"):
        mdr.azimuthal_profile(surface)


# --- from the shell --------------------------------------------------------------------------------------


@pytest.fixture
def rough_file(tmp_path):
    rng = np.random.default_rng(1)
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.fftfreq(64)))
    q[0, 0] = np.inf
    heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal(q.shape)) * q**-1.7).real
    file = tmp_path / "rough.csv"
    np.savetxt(file, heights / heights.std(), delimiter=",")
    return file


def test_a_spectrum_from_the_shell(rough_file, tmp_path, shell):
    known = ("--size", "1 um", "--unit", "nm")
    status, out, error = shell("topography", rough_file, *known, "-o", tmp_path / "out")
    assert (status, error) == (0, "")
    assert "64 x 64 heights on 1 µm x 1 µm" in out
    assert "a plane subtracted" in out
    assert "H = 0." in out
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["topography.csv", "topography.png"]
    assert (tmp_path / "out" / "topography.csv").read_text().startswith("wave_number [m^-1],wavelength [m]")
    status, out, _ = shell("topography", rough_file, *known, "--periodic", "--detrend", "none", "--json")
    data = json.loads(out)
    surface = mdr.read_topography(rough_file, size="1 um", unit="nm")
    result = mdr.power_spectrum(surface, periodic=True)
    assert data["study"]["law"]["values"] == [
        None if np.isnan(value) else value for value in result["law"].values.tolist()
    ]
    assert data["claims"]["law"]["level"] == "APPROXIMATE"
    for bad, words in (
        ((), "no unit of the heights"),
        ((*known, "--tip-radius", "1 m"), "resolves no wave"),
        ((*known, "--detrend", "cubic"), "detrend = 'cubic'"),
        ((*known, "--channel", "3"), "one surface only"),
        ((*known, "--profile"), "not one bump"),
        ((*known, "--profile", "--periodic"), "leave them out with --profile"),
    ):
        status, _, error = shell("topography", rough_file, *bad)
        assert status == 1
        assert words in error
        assert len(error.splitlines()) == 1


def test_a_profile_from_the_shell(tmp_path, shell):
    x = (np.arange(64) + 0.5) / 64
    ball = tmp_path / "ball.csv"
    np.savetxt(ball, -np.add.outer((x - 0.55) ** 2, (x - 0.5) ** 2).T / 10.0, delimiter=",")
    arguments = ("topography", ball, "--size", "1 um", "--unit", "um", "--profile")
    status, out, error = shell(*arguments, "-o", tmp_path / "out")
    assert (status, error) == (0, "")
    assert "one bump with its apex at (550 nm, 500 nm)" in out
    profile = mdr.read_profile(tmp_path / "out" / "profile.csv", interpolation=mdr.CubicSpline())
    assert profile.gap(0.3e-6) == pytest.approx(0.3e-6**2 / 10e-6, rel=1e-6)
    data = json.loads(shell(*arguments, "--json")[1])
    assert data["study"]["radius"]["values"] == profile.radius.tolist()
    assert data["rows"] == profile.radius.size
