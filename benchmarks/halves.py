"""Measured records fitted with every law: do their odd and their even samples say the same?

``python -m benchmarks.halves`` fits the force curves that are beside the repository (see ``benchmarks/records.py``), whole and in halves, and prints
what is found, what is refused and why, and whether the halves agree: the difference of the logarithms of their values against the 95 % of what a
bootstrap of blocks of the residuals of both makes of it. ``--only JKR DMT`` takes some of the laws.

The tips of the records are not known: a paraboloid of 5 um stands for all, so that the moduli are numbers to be compared with each other only.
"""

import argparse
import math

import numpy as np

import pymdr as mdr
from benchmarks.records import records

TIP = mdr.Paraboloid("5 um")
SEED, DRAWS, BLOCKS, SHORTEST = 16, 2000, 50, 8
FOLLOWED = 600
"""Samples that bodies with memory are followed over: means of blocks."""


def contact(adhesion=None):
    """A half-space under the tip."""
    return mdr.Contact(TIP, mdr.Elastic("10 kPa", 0.5), adhesion=adhesion)


STICKY = ("body.young", "adhesion.work")
LAYER = mdr.Layered([mdr.Layer(mdr.Elastic("10 kPa", 0.5), "10 um")])
SLOW = mdr.Viscoelastic(mdr.StandardSolid("3 kPa", "3 kPa", "0.3 s"), poisson=0.5)
LAWS = {
    "Hertz": (contact(), ("body.young",), "approach"),
    "layer": (
        mdr.Contact(TIP, LAYER),
        ("body.layers[0].material.young", "body.layers[0].thickness"),
        "approach",
    ),
    "JKR": (contact(mdr.JKR("0.1 mJ/m^2")), STICKY, "retreat"),
    "DMT": (contact(mdr.DMT("0.1 mJ/m^2")), STICKY, "retreat"),
    "Maugis-Dugdale": (contact(mdr.MaugisDugdale("0.1 mJ/m^2", range="50 nm")), STICKY, "retreat"),
    "memory": (
        mdr.Contact(TIP, SLOW),
        ("body.shear.equilibrium", "body.shear.modulus", "body.shear.time"),
        "record",
    ),
}


def part(curve, first, step):
    """Every so many samples."""
    cut = slice(first, None, step)
    channel = "indentation" if curve.travel is None else "travel"
    return mdr.MeasuredCurve(
        force=curve.force[cut],
        time=None if curve.time is None else curve.time[cut],
        spring_constant=curve.spring_constant,
        **{channel: curve.position[cut]},
    )


def thinned(curve, most):
    """Means of blocks of equal numbers of samples."""
    size = max(1, math.ceil(curve.force.size / most))
    count = curve.force.size // size

    def means(column):
        return column[: count * size].reshape(count, size).mean(axis=1)

    return mdr.MeasuredCurve(
        force=means(curve.force),
        time=means(curve.time),
        travel=means(curve.position),
        spring_constant=curve.spring_constant,
    )


def likely(result, seed, draws=DRAWS):
    """
    What may be off in the free numbers of a fit, shape (draws, numbers).

    Blocks of the residuals keep or turn their signs by chance (the dependent wild bootstrap, Shao 2010): so they stay where they are larger, in
    contact. What least squares make of them is one step of Gauss and Newton by the rates of the residuals.
    """
    best = result.free
    residual, rates = result.search.residuals(best), result.search.slopes(best)
    length = int(np.clip(2.0 * result.correlated, SHORTEST, max(residual.size // BLOCKS, SHORTEST)))
    of_blocks = np.add.reduceat(np.linalg.pinv(rates) * residual, np.arange(0, residual.size, length), axis=1)
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], (draws, of_blocks.shape[1]))
    return signs @ of_blocks.T


def halves(start, curve, free):
    """What is found in the whole record, and for each number the difference of its halves and the largest one that is likely, as logarithms."""
    fitted = mdr.fit(start, curve, free)
    even, odd = (mdr.fit(start, part(curve, i, 2), free) for i in (0, 1))
    largest = np.quantile(np.abs(likely(even, SEED) - likely(odd, SEED + 1)), 0.95, axis=0)
    return fitted, {
        name: (math.log(even[name].value / odd[name].value), float(largest[i])) for i, name in enumerate(free)
    }


def main(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=LAWS, default=list(LAWS))
    given = parser.parse_args(words)
    agreed, compared = 0, 0
    for law in given.only:
        start, free, segment = LAWS[law]
        for name, record in records(segment):
            curve = thinned(record, FOLLOWED) if start.is_viscoelastic else record.leave_out_marked()
            try:
                result, own = halves(start, curve, free)
            except mdr.PymdrError as error:
                print(f"{law}, {name}: {error}", flush=True)
                continue
            for number, (difference, largest) in own.items():
                agree = abs(difference) <= largest
                agreed, compared = agreed + agree, compared + 1
                print(
                    f"{law}, {name}: {result[number]}; waves {result.waves:.2g}; halves differ by {difference:+.2%}, up to {largest:.2%} is likely{'' if agree else ': TOO MUCH'}",
                    flush=True,
                )
    print(f"{agreed} of {compared} numbers agree")


if __name__ == "__main__":
    main()
