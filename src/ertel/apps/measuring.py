"""Measurements and pages: what `ertel compare` does with a file, `ertel fringes` and `ertel report`."""

from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ertel.apps.arguments import Measured, Overwrite, option, path_argument, path_option
from ertel.apps.terminal import BAD_INPUT, bad_input, leave, local_path, placing, print_json, print_text, say, shown

if TYPE_CHECKING:  # it takes long to import
    import xarray as xr

    from ertel.results.alignment import Comparison
    from ertel.results.measurements import Measurement


def measurement_in(file: Path, given: Measured, light: str = "mono", along: str = "x") -> "Measurement":
    """The measurement in a file.  light: of an intensity.  Raises ValueError."""
    from ertel.inputs.fits import interferometer
    from ertel.results.measurements import READ, Measurement

    units: dict[str, Any] = dict(each.partition("=")[::2] for each in given.column or [])
    if wrong := sorted(units.keys() & {*READ, "optics"}):
        raise ValueError(f"--column {wrong[0]}: must be a place, a time or a quantity, such as x=um or h=nm")
    rig = interferometer(light, given.wavelength, given.coatings, given.index)
    names = (given.align or "").replace(",", " ").split()
    return Measurement.read(file, at=given.at, along=along, align=names, optics=rig, index=given.index, **units)


def beside(directory: Path, measurement: "Measurement") -> tuple["xr.Dataset", "Comparison"]:
    """A measurement beside a run, or a curve beside a study, and the data of these; it needs no JAX.

    Raises ValueError where the directory holds something else, or the run does not have the quantity.
    """
    from ertel.runs.arrays import AppendedData, read
    from ertel.runs.directory import DATA, is_run, read_case
    from ertel.runs.fit_result import open_study

    if measurement.kind == "curve":
        result: Any = open_study(directory)
    elif is_run(directory):
        data = read(directory / DATA, AppendedData.advice)
        result = SimpleNamespace(dataset=data, case=read_case(directory))
    else:
        raise ValueError(f"{shown(directory)}: is not a run directory, and {measurement.name} is a {measurement.kind}")
    return result.dataset, measurement.compared(result)


def compare_measured(
    directory: Path, measurement: "Measurement", plot: Path | None, as_json: bool, overwrite: bool, named: bool
) -> None:
    """Print a measurement beside a run, and draw both.  named: whether the user says where."""
    from ertel import plots

    with bad_input():
        data, found = beside(directory, measurement)
        if plot:
            with placing(plot.parent, overwrite, named, [plot.name]) as place:
                plots.measured(data, found).savefig(place / plot.name)
    if as_json:
        columns = {name: getattr(found, name).tolist() for name in ("x", "measured", "computed", "difference")}
        quantity = found.measurement.quantity
        told = {"rms": found.rms, "shift": dict(found.shift), "warnings": found.warnings}
        print_json({"quantity": quantity, "at": found.where, **told, **columns})
    else:
        print(found)
    if plot:
        print_text(shown(plot))


def fringes(
    frame: Annotated[Path, path_argument("FRAME", "PNG or TIFF of an interferogram in monochromatic light.")],
    pixel: Annotated[str, option("Size of a pixel on the surface, such as 1.2um.", "LENGTH")],
    line: Annotated[str, option("Through the centre: x, y, or the angle from x towards y (down).", "x|y|ANGLE")] = "x",
    centre: Annotated[str, option("Column and row of a pixel, or found by symmetry.", "auto|COLUMN,ROW")] = "auto",
    film: Annotated[str, option("Film in the centre, about: then the film is found, too.", "LENGTH")] = "",
    wavelength: Annotated[str, option("Wavelength of the light.", "LENGTH")] = "532 nm",
    coatings: Annotated[str | None, option("Layers on the glass, as of ertel plot.", "LAYERS")] = None,
    index: Annotated[float | None, option("Index of the oil.", "NUMBER")] = None,
    hertz: Annotated[
        str, option("Hertz pressure and radius of the contact, for the index of the oil there.", "PRESSURE,LENGTH")
    ] = "",
    page: Annotated[int | None, option("Page of a TIFF with several, from 1.", min=1)] = None,
    out: Annotated[Path | None, path_option("File of columns; default FRAME.csv here.", "FILE")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Read the light along a line of a camera's frame, for ertel compare and ertel fit.

    The file has the columns x_m, intensity and sigma. With --film, about that in the centre, it has those of the film,
    x_m, h_m and sigma_m, at the points where it cannot as well turn on a fringe as pass it.
    """
    import numpy as np

    from ertel.inputs.fits import interferometer
    from ertel.inputs.frames import line_of_frame

    file = out or Path(f"{frame.stem}.csv")
    with bad_input():
        rig = interferometer("mono", wavelength, coatings, index)
        found = line_of_frame(frame, pixel, line, centre, rig, film, hertz, page)
        header, columns = "x_m,intensity,sigma", (found.x, found.intensity, np.full_like(found.x, found.noise))
        if found.h is not None and found.sigma is not None:
            header, columns = "x_m,h_m,sigma_m", (found.x, found.h, found.sigma)
        with placing(file.absolute().parent, overwrite) as place:
            table = np.transpose(columns)[np.isfinite(columns).all(axis=0)]
            np.savetxt(place / file.name, table, "%.6g", ",", header=header, comments="")
    column, row = found.centre
    say(f"centre in column {column:g}, row {row:g}; {len(table)} of {len(found.x)} points are known")
    print_text(shown(file))


def report(
    directory: Annotated[Path, path_argument("DIR", "Directory of a run, or of a study or fit.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", parser=local_path, metavar="FILE", help="File; default DIR/report.pdf."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a run, a study or a fit as one page of A4: case, pictures, numbers with their errors, and warnings."""
    from ertel.apps import reports

    file = out or directory / "report.pdf"
    if file.suffix.lower() not in (".pdf", ".png", ".svg"):
        leave(BAD_INPUT, f"--out {shown(file)}: must end with .pdf, .png or .svg")
    reports.require_content(directory)
    with bad_input(), placing(file.absolute().parent, overwrite, out is not None, [file.name]) as place:
        reports.drawn(reports.page_of(directory)).savefig(place / file.name)
    print_text(shown(file))
