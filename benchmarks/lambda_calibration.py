"""The disputed point: lambda of the lines of rough surfaces, calibrated on boundary elements in three dimensions.

``python -m benchmarks.lambda_calibration --hurst 0.2 0.8 --pixels 128 256 --realisations 6 --out DIR`` presses realisations of
squares, with 4 pixels for the shortest wave, and prints lambda, misfits and ranges. In DIR it writes a figure of each and
``lambda.csv``; every load of every surface is kept there, and the same command goes on from there.
"""

import argparse
from pathlib import Path

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

import pymdr as mdr

PER_WAVE = 4
HEAD = "hurst,bandwidth,realisations,lambda,lambda_low,lambda_high,misfit,load,stiffness,stiffness_low,stiffness_high"
CURVES = ("line_stiffness", "fitted_stiffness", "power_law", "area", "line_fraction")


def surface(hurst, pixels):
    """A square of as many shortest waves as the pixels resolve; heights and sizes scale out."""
    return mdr.RoughSurface(hurst=hurst, rms=1e-3, size=1.0, shortest=PER_WAVE / pixels)


def rows(result):
    """Lines of the table."""
    attrs = result.data.attrs
    low, high = attrs["coefficients"]
    head = f"{attrs['hurst']:g},{attrs['bandwidth']:g},{attrs['realisations']},{result.coefficient:.3f},{low:.3f},{high:.3f},{attrs['misfit']:.4f}"
    columns = ("load", "stiffness", "stiffness_low", "stiffness_high", *CURVES)
    numbers = zip(*(result.data[name].values for name in columns), strict=True)
    return [f"{head}," + ",".join(f"{value:.4g}" for value in row) for row in numbers]


def main(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hurst", type=float, nargs="+", default=[0.2, 0.4, 0.6, 0.8])
    parser.add_argument("--pixels", type=int, nargs="+", default=[128], help="along a side, 4 for a wave")
    parser.add_argument("--realisations", type=int, default=6)
    parser.add_argument("--out", type=Path, default=Path("lambda_calibration"))
    given = parser.parse_args(words)
    works = [(hurst, pixels) for pixels in given.pixels for hurst in given.hurst]
    given.out.mkdir(parents=True, exist_ok=True)
    table = [f"{HEAD},{','.join(CURVES)}"]
    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    # a work of twice the pixels takes some five times as long
    total = sum(pixels**2.3 for _, pixels in works)
    with Progress(*columns) as bar:
        task = bar.add_task("pressing", total=total)
        before = 0.0
        for hurst, pixels in works:
            name, size = f"H{hurst:g}_{pixels}", pixels**2.3

            def report(done, of, name=name, size=size, before=before):
                bar.update(task, description=name, completed=before + size * done / of)

            fitted = mdr.calibrate_coefficient(
                surface(hurst, pixels),
                realisations=given.realisations,
                keep=given.out / name,
                progress=report,
            )
            before += size
            bar.console.print(str(fitted), markup=False, soft_wrap=True)
            fitted.plot().savefig(given.out / f"lambda_{name}.png", dpi=150)
            table += rows(fitted)
            (given.out / "lambda.csv").write_text("\n".join(table) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
