"""How accurate results are, and whether they say so: random problems against references of another kind.

``python -m tests.accuracy --count 10000`` draws fresh problems, an eleventh of each kind: profiles, bodies with memory, layers,
force curves, fits, friction, adhesion, torsion, stress, impacts and shifts in the plane (reference/random_problems.py and random_histories.py say against what
they are compared); ``--kinds memory`` draws one kind alone.
Profiles are solved at depths and forces over twelve decades of the radius; contact radius, force, energy, indentation, stiffness
and pressure are compared with reference/quadrature.py. A value violates its claim if

    |value - truth| > 10 * claims[name].error * size + 1e-14 * size,

where an error that is not known counts as 0 and the size of a quantity is the integral of its absolute integrand; for a contact radius a the rounding is
1e-14 a (1 + condition) with the condition g / (a g') of its equation. Of the other kinds the size is the value, and 1e-9 and the
error of the reference are allowed beside the claim. ``--seed`` and ``--only`` replay a problem. ``--folder`` keeps what is done: the
same command goes on where it was stopped, and with a larger ``--count`` adds to it. ``--cluster tcp://node:8786`` hands the problems to a
dask scheduler, whose workers have this folder's parent in their PYTHONPATH; the numbers are the same.
"""

import argparse
import importlib.util
import json
import pickle
import re
import secrets
import sys
import time
import warnings
from collections import Counter, defaultdict
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from pymdr.solving.workers import in_order
from pymdr.workbench.cli.options import at_work

FOLDER = Path(__file__).parent / "reference"


def reference_module(name):
    """A module of the folder reference, which is no package."""
    known = f"pymdr_reference_{name}"
    if known not in sys.modules:
        spec = importlib.util.spec_from_file_location(known, FOLDER / f"{name}.py")
        sys.modules[known] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[known])
    return sys.modules[known]


quadrature = reference_module("quadrature")
random_profiles = reference_module("random_profiles")
random_problems = reference_module("random_problems")
reference_module("vector_springs")
random_histories = reference_module("random_histories")
FAMILIES = {**random_problems.FAMILIES, **random_histories.FAMILIES}
KINDS = ("profiles", *FAMILIES)

LONG = np.longdouble
YOUNG, POISSON = 1.0e9, 0.3
MODULUS = LONG(YOUNG) / (1 - LONG(POISSON) ** 2)
EPS = LONG(np.finfo(float).eps)
ROUNDING = LONG("1e-14")
EXACT_WITHIN = 1e-9
SMALLEST, LARGEST = LONG("1e-270"), LONG("1e270")
QUANTITIES = (
    "contact_radius",
    "normal_force",
    "elastic_energy",
    "indentation",
    "normal_stiffness",
    "pressure",
)


@dataclass(frozen=True)
class Effort:
    """How much of every problem is judged."""

    full: bool = True
    """Whether problems other than profiles are drawn from the wider set."""
    rows: int = 8
    energies: int = 2
    pressures: int = 2
    """Rows whose pressure is read, each at three radii."""


QUICK = Effort(False, 4, 1, 1)


@dataclass(frozen=True)
class Value:
    """One number of a result beside the truth."""

    quantity: str
    control: str
    at: str
    value: float
    truth: float
    miss: float
    """|value - truth| / size."""
    claimed: float
    allowed: float

    @property
    def violated(self):
        """Whether it lies further off than its claim allows, or is no number."""
        return not self.miss <= self.allowed


@dataclass
class Outcome:
    """What became of one profile."""

    index: int
    kind: str
    gives: str
    smooth: bool
    words: str
    values: list[Value] = field(default_factory=list)
    exact: list[bool] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    crashes: list[str] = field(default_factory=list)
    unsettled: list[str] = field(default_factory=list)
    """What the reference could not settle."""
    unknown: int = 0
    """Values whose error is claimed not to be known."""
    invalid: int = 0
    """Rows that are claimed not to be valid."""
    elsewhere: int = 0
    """Rows solved at another disk of the same depth, where g does not rise everywhere."""
    seconds: tuple[float, float] = (0.0, 0.0)


def without_numbers(message):
    """A message whose numbers are struck out, so that it can be counted."""
    return re.sub(r"-?\d+(\.\d+)?([eE][-+]?\d+)?", "#", str(message))[:160]


def claimed_errors(result, name, rows):
    """The relative error that is claimed of every row; 0 where none is or it is not known."""
    claim = result.claims.get(name)
    if claim is None:
        return np.zeros(rows)
    if claim.error is None:
        # the strictest reading: nothing is claimed to be off
        return np.zeros(rows)
    return np.broadcast_to(np.asarray(claim.error, dtype=float), (rows,))


def is_exact(result):
    """Whether the main quantities are all claimed EXACT."""
    names = [n for n in QUANTITIES if n in result.claims]
    return all(result.claims[n].level.name in ("EXACT", "NOT_VALID") for n in names)


def ask(outcome, mdr, contact, path):
    """The result, or None with the refusal or crash noted."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return mdr.solve(contact, path)
    except mdr.errors.PymdrError as error:
        outcome.refusals.append(without_numbers(error))
    except Exception as error:
        outcome.crashes.append(f"{type(error).__name__}: {without_numbers(error)}")
    return None


def one_problem(job):
    """Draw, solve and judge one problem: job = (seed, index, effort, kinds)."""
    import pymdr as mdr
    import pymdr.errors

    mdr.errors = pymdr.errors
    seed, index, effort, kinds = job
    rng, kind = np.random.default_rng([seed, index]), kinds[index % len(kinds)]
    if kind == "profiles":
        return one_profile(mdr, rng, index, effort)
    outcome, start = Outcome(index, kind, "", False, ""), time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for result in FAMILIES[kind](rng, mdr, effort.full):
                add_comparison(outcome, result)
    except mdr.errors.PymdrError as error:
        outcome.refusals.append(without_numbers(error))
    except Exception as error:
        outcome.crashes.append(f"{type(error).__name__}: {without_numbers(error)}")
    outcome.seconds = (time.process_time() - start, 0.0)
    return outcome


def add_comparison(outcome, computed):
    """Judge one value beside its reference."""
    if computed.claimed is None:
        outcome.unknown += 1
        return
    miss = abs(computed.value - computed.truth) / (abs(computed.truth) or 1.0)
    allowed = 10.0 * computed.claimed + EXACT_WITHIN + computed.uncertainty
    outcome.exact.append(computed.exact)
    outcome.values.append(
        Value(
            computed.quantity,
            "",
            computed.at,
            computed.value,
            computed.truth,
            miss,
            computed.claimed,
            allowed,
        )
    )


def one_profile(mdr, rng, index, effort):
    """Draw, solve and judge one profile."""
    drawn = random_profiles.random_profile(rng)
    outcome = Outcome(index, drawn.kind, drawn.gives, drawn.smooth, drawn.words)
    start = time.process_time()
    try:
        profile = drawn.build(mdr)
        curve = drawn.curve(profile)
    except mdr.errors.PymdrError as error:
        outcome.refusals.append(without_numbers(error))
        return outcome
    except Exception as error:
        outcome.crashes.append(f"{type(error).__name__}: {without_numbers(error)}")
        return outcome
    panel, offset, computed = askable(rng, drawn, curve, effort.rows)
    if panel.size == 0:
        return outcome
    contact = mdr.Contact(profile, mdr.Elastic(YOUNG, POISSON))
    solving = 0.0
    for control in ("indentation", "normal_force"):
        targets = np.asarray(
            computed.g if control == "indentation" else 2 * MODULUS * computed.moment, dtype=float
        )
        began = time.process_time()
        result = ask(outcome, mdr, contact, mdr.Path(**{control: targets}))
        solving += time.process_time() - began
        if result is not None:
            outcome.exact.append(is_exact(result))
            try:
                judge(outcome, rng, drawn, curve, result, control, targets, panel, offset, effort)
            except mdr.errors.PymdrError as error:
                outcome.refusals.append(without_numbers(error))
            except ArithmeticError as error:
                outcome.unsettled.append(str(error)[:160])
            except Exception as error:
                outcome.crashes.append(f"reading: {type(error).__name__}: {without_numbers(error)}")
    outcome.seconds = (solving, time.process_time() - start - solving)
    return outcome


def askable(rng, drawn, curve, rows):
    """Positions with g, g' > 0 in the range of doubles whose depth, rounded, still lies in the same panel."""
    base, offset = random_profiles.positions(rng, drawn, curve, rows)
    panel, offset = quadrature.place(curve, base, offset)
    computed = quadrature.images(curve, panel, offset)
    sizes = [
        computed.g,
        computed.slope,
        computed.moment * MODULUS,
        computed.g**2 * quadrature.radius(curve, panel, offset),
    ]
    good = np.all([(s > SMALLEST) & (s < LARGEST) for s in sizes], axis=0) & (
        computed.g_size < 1e3 * computed.g
    )
    below = np.flatnonzero(good & (panel > 0))
    widths = np.diff(curve.edges)
    if below.size:
        at_edge = quadrature.images(curve, panel[below] - 1, widths[panel[below] - 1])
        good[below] &= computed.g[below] - at_edge.g > 1e-12 * computed.g_size[below]
        good[below] &= computed.moment[below] - at_edge.moment > 1e-12 * computed.moment_size[below]
    rest = np.append(widths, np.inf)[panel] - offset
    good &= rest > 1e-12 * quadrature.radius(curve, panel, offset)
    kept = quadrature.Images(*(getattr(computed, n)[good] for n in quadrature.Images.__dataclass_fields__))
    return panel[good], offset[good], kept


def judge(outcome, rng, drawn, curve, result, control, targets, panel, offset, effort):
    """Hold every row of a result against the truth."""
    of = "g" if control == "indentation" else "moment"
    target = targets.astype(LONG) if of == "g" else targets.astype(LONG) / (2 * MODULUS)
    offset = quadrature.polish(curve, target, panel, offset, of)
    rows = targets.size
    solved_radius = column(result, "contact_radius", rows)
    outcome.invalid += int(np.isnan(solved_radius).sum())
    if drawn.kind == "samples":
        panel, offset = elsewhere(outcome, curve, target, of, panel, offset, solved_radius)
    a = quadrature.radius(curve, panel, offset)
    truth = quadrature.images(curve, panel, offset)
    errors = {name: claimed_errors(result, name, rows) for name in QUANTITIES}
    size = truth.g_size if of == "g" else truth.moment_size / a
    condition = size / (a * truth.slope)
    quantities = {
        "contact_radius": (a, a, ROUNDING * (1 + condition)),
        "normal_stiffness": (2 * MODULUS * a, 2 * MODULUS * a, ROUNDING * (1 + condition)),
        "normal_force": (2 * MODULUS * truth.moment, 2 * MODULUS * truth.moment_size, ROUNDING),
        "indentation": (truth.g, truth.g_size, ROUNDING),
    }
    valid = ~np.isnan(solved_radius)
    for name, (exact, size, rounding) in quantities.items():
        values = column(result, name, rows)
        rounding = np.broadcast_to(rounding, (rows,))
        for row in np.flatnonzero(valid):
            add(
                outcome,
                name,
                control,
                row,
                a,
                values[row],
                exact[row],
                size[row],
                errors[name][row],
                rounding[row],
            )
    if of == "g":
        some = np.flatnonzero(valid)[: effort.energies]
        if some.size:
            squares = quadrature.squared(curve, panel[some], offset[some])
            size = squares * (truth.g_size[some] / truth.g[some]) ** 2
            values = column(result, "elastic_energy", rows)
            for i, row in enumerate(some):
                add(
                    outcome, "elastic_energy", control, row, a, values[row], MODULUS * squares[i], MODULUS * size[i],
                    errors["elastic_energy"][row], ROUNDING,
                )  # fmt: skip
        for row in np.flatnonzero(valid)[: effort.pressures]:
            judge_pressure(
                outcome, rng, curve, result, row, (panel[row], offset[row]), a, truth, errors, condition
            )


def judge_pressure(outcome, rng, curve, result, row, a_at, a, truth, errors, condition):
    """The pressure of one row at a few radii; what the rounding of a and r does to it is allowed."""
    radius = float(a[row])
    r = radius * np.sort(
        [rng.uniform(0.0, 1.0), random_profiles.log_uniform(rng, 1e-6, 1.0), 1.0 - 10.0 ** -rng.uniform(1, 6)]
    )
    inside = r.astype(LONG) < a[row] * (1 - LONG("1e-13"))
    values = np.asarray(result.field("pressure", r=r, step=int(row)), dtype=float)
    claimed = errors["pressure"][row]
    spread = a[row] * (2 * EPS + 10 * errors["contact_radius"][row] + ROUNDING * condition[row])
    for k in np.flatnonzero(inside):
        panel, offset = quadrature.place(curve, r[k : k + 1].astype(LONG))
        exact, size = quadrature.pressure_integral(curve, (panel[0], offset[0]), a_at)
        steep = truth.slope_size[row] / np.sqrt((a[row] - r[k]) * (a[row] + r[k]))
        scale = MODULUS / quadrature.PI
        add(
            outcome, "pressure", "indentation", row, a, values[k], scale * exact, scale * size, claimed,
            ROUNDING + steep * spread / size, f", r = {float(r[k])!r}",
        )  # fmt: skip


def column(result, name, rows):
    """A quantity over the rows, nan where it is not given."""
    return result.data[name].values if name in result.data else np.full(rows, np.nan)


def add(outcome, name, control, row, a, value, truth, size, claimed, rounding, more=""):
    """Judge one value, of which nothing is known where ten times its claim is all of it."""
    miss = abs(LONG(value) - truth) / (max(size, abs(LONG(value))) if 10.0 * claimed >= 1.0 else size)
    outcome.values.append(
        Value(
            name, control, f"row {row}, a = {float(a[row])!r}{more}", float(value), float(truth), float(miss),
            float(claimed), float(10 * LONG(claimed) + rounding),
        )
    )  # fmt: skip


def elsewhere(outcome, curve, target, of, panel, offset, solved_radius):
    """Where g of samples falls in places several disks have one depth: judge the one that was chosen."""
    a = quadrature.radius(curve, panel, offset)
    for row in np.flatnonzero(abs(solved_radius - a) > 1e-4 * a):
        if not 0.0 < solved_radius[row] < curve.edges[-1]:
            continue
        k, e = quadrature.place(curve, np.array([LONG(solved_radius[row])]))
        there = quadrature.images(curve, k, e)
        value, size = (there.g, there.g_size) if of == "g" else (there.moment, there.moment_size)
        if abs(value[0] - target[row]) <= 1e-6 * size[0]:
            outcome.elsewhere += 1
            panel[row], offset[row] = k[0], quadrature.polish(curve, target[row : row + 1], k, e, of)[0]
    return panel, offset


@dataclass
class Study:
    """All outcomes of a seed."""

    seed: int
    outcomes: list[Outcome]

    @property
    def violations(self):
        """Pairs of outcome and value, worst first."""
        results = [(o, v) for o in self.outcomes for v in o.values if v.violated]
        return sorted(results, key=lambda pair: -np.nan_to_num(pair[1].miss / pair[1].allowed, nan=np.inf))

    @property
    def crashes(self):
        """Outcomes that ended in anything but an answer or a refusal."""
        return [o for o in self.outcomes if o.crashes]

    def fraction_exact(self, smooth=True):
        """The fraction of solved profiles, smooth or not, whose main quantities are all claimed EXACT."""
        solved = [all(o.exact) for o in self.outcomes if o.exact and o.smooth == smooth]
        return float(np.mean(solved)) if solved else float("nan")

    def overestimate(self, quantity=None):
        """The median of claimed over actual error, of values with a claim above 0."""
        ratios = [
            v.claimed / max(v.miss, 1e-15)
            for o in self.outcomes
            for v in o.values
            if v.claimed > 0.0 and quantity in (None, v.quantity)
        ]
        return float(np.median(ratios)) if ratios else float("nan")

    def table(self, worst=30):
        """The study in words and numbers."""
        lines = [f"seed {self.seed}, {len(self.outcomes)} problems"]
        by_kind = defaultdict(list)
        for o in self.outcomes:
            by_kind[o.kind].append(o)
        lines.append(
            f"{'kind':14}{'problems':>9}{'refused':>9}{'crashed':>9}{'values':>9}{'violated':>9}{'problems':>9}"
            f"{'exact':>8}{'median':>10}{'99 %':>10}{'largest':>10}{'solve/s':>9}{'ref/s':>8}"
        )
        for kind, group in [*sorted(by_kind.items()), ("all", self.outcomes)]:
            values = [v for o in group for v in o.values]
            miss = np.array([v.miss for v in values]) if values else np.array([np.nan])
            solved = [all(o.exact) for o in group if o.exact]
            lines.append(
                f"{kind:14}{len(group):9}{sum(bool(o.refusals) for o in group):9}{sum(bool(o.crashes) for o in group):9}"
                f"{len(values):9}{sum(v.violated for v in values):9}"
                f"{sum(any(v.violated for v in o.values) for o in group):9}"
                f"{np.mean(solved) if solved else np.nan:8.1%}"
                f"{np.median(miss):10.1e}{np.quantile(miss, 0.99):10.1e}{np.max(miss):10.1e}"
                f"{np.mean([o.seconds[0] for o in group]):9.3f}{np.mean([o.seconds[1] for o in group]):8.3f}"
            )
        lines.append("")
        lines.append(
            f"{'quantity':18}{'values':>9}{'violated':>9}{'median':>10}{'99 %':>10}{'claimed/actual':>16}"
        )
        for name in sorted({v.quantity for o in self.outcomes for v in o.values}):
            values = [v for o in self.outcomes for v in o.values if v.quantity == name]
            if values:
                miss = np.array([v.miss for v in values])
                lines.append(
                    f"{name:18}{len(values):9}{sum(v.violated for v in values):9}{np.median(miss):10.1e}"
                    f"{np.quantile(miss, 0.99):10.1e}{self.overestimate(name):16.3g}"
                )
        lines += [
            "",
            f"EXACT: {self.fraction_exact():.1%} of smooth profiles solved, {self.fraction_exact(False):.1%} of the others",
            f"median of claimed over actual error: {self.overestimate():.3g}",
            f"values of unknown error: {sum(o.unknown for o in self.outcomes)}; "
            f"rows claimed not valid: {sum(o.invalid for o in self.outcomes)}; "
            f"at another disk of samples: {sum(o.elsewhere for o in self.outcomes)}",
        ]
        for title, name in (
            ("refusals", "refusals"),
            ("crashes", "crashes"),
            ("left open by the reference", "unsettled"),
        ):
            counts = Counter(m for o in self.outcomes for m in set(getattr(o, name)))
            first = {m: o for o in reversed(self.outcomes) for m in getattr(o, name)}
            lines.append(f"\n{title}: {sum(counts.values())}")
            lines += [
                f"{n:6}  {m}  [--only {first[m].index}, {first[m].kind}]" for m, n in counts.most_common(20)
            ]
        computed = self.violations
        lines.append(
            f"\nviolations: {len(computed)} values of {len({o.index for o, _ in computed})} problems"
        )
        shown: Counter = Counter()
        for o, v in computed:
            shown[o.index] += 1
            if len(shown) > worst:
                break
            if shown[o.index] == 1:
                lines.append(
                    f"--seed {self.seed} --only {o.index}: {o.kind} ({o.gives}{', smooth' if o.smooth else ''}) {o.words[:300]}\n"
                    f"    {v.quantity} by {v.control}, {v.at}: {v.value!r}, truth {v.truth!r}; "
                    f"off {v.miss:.2e}, allowed {v.allowed:.2e}, claimed {v.claimed:.2e}"
                )
        return "\n".join(lines)


class KeptOutcomes:
    """A folder of the outcomes of one seed, a file for each minute."""

    def __init__(self, folder, seed, effort, kinds):
        self.folder = Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        about, mark = (
            {"seed": seed, "effort": asdict(effort), "kinds": list(kinds)},
            self.folder / "about.json",
        )
        if not mark.exists():
            mark.write_text(json.dumps(about))
        elif json.loads(mark.read_text()) != about:
            raise SystemExit(f"{folder} has outcomes of {mark.read_text()}; give the same, or another folder")

    def read(self):
        """All outcomes so far."""
        return [o for file in self._files() for o in pickle.loads(file.read_bytes())]

    def add(self, outcomes):
        """Write some more, whole or not at all."""
        unfinished = self.folder / "unfinished"
        unfinished.write_bytes(pickle.dumps(outcomes))
        unfinished.rename(self.folder / f"outcomes-{len(self._files()):06d}.pickle")

    def _files(self):
        return sorted(self.folder.glob("outcomes-*.pickle"))


def study(
    seed, count, workers=1, only=None, progress=False, effort=Effort(), kinds=("profiles",), folder=None
):
    """
    Judge `count` random problems.

    Parameters
    ----------
    seed : int
        Problem i is drawn from the generator of (seed, i), of the kind i modulo the number of `kinds`.
    count : int
    workers : int or dask.distributed.Client
    only : sequence of int, optional
        Indices instead of the first `count`.
    progress : bool
        Whether to tell on standard error how far it is.
    effort : Effort
    kinds : sequence of str
    folder : path, optional
        Of what is done.
    """
    kept = None if folder is None else KeptOutcomes(folder, seed, effort, kinds)
    outcomes = [] if kept is None else kept.read()
    done = {o.index for o in outcomes}
    wanted = (int(i) for i in (range(count) if only is None else only))
    jobs = [(seed, i, effort, tuple(kinds)) for i in wanted if i not in done]
    start = reported = written = time.monotonic()
    fresh = []
    for outcome in in_order(one_problem, jobs, workers):
        outcomes.append(outcome)
        fresh.append(outcome)
        now = time.monotonic()
        if kept is not None and now - written > 60.0:
            kept.add(fresh)
            fresh, written = [], now
        if progress and now - reported > 10.0:
            reported = now
            bad = [o.index for o in outcomes if any(v.violated for v in o.values)]
            print(
                f"{len(outcomes) - len(done)} of {len(jobs)} after {now - start:.0f} s, violated: {bad}",
                file=sys.stderr,
                flush=True,
            )
    if kept is not None and fresh:
        kept.add(fresh)
    return Study(seed, sorted(outcomes, key=lambda o: o.index))


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=None, help="a fresh one unless given")
    parser.add_argument("--only", type=int, nargs="+", help="indices of problems to replay")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, help="all unless given")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--cluster", metavar="ADDRESS", help="a dask scheduler instead of --workers")
    parser.add_argument("--folder", help="keeps what is done; the same command goes on")
    parser.add_argument("--worst", type=int, default=30, help="how many violated problems to list")
    parser.add_argument("--quick", action="store_true", help="smaller problems, 0.2 s each or less")
    given = parser.parse_args()
    seed = given.seed
    if seed is None and given.folder and (about := Path(given.folder) / "about.json").exists():
        seed = json.loads(about.read_text())["seed"]
    seed = secrets.randbits(31) if seed is None else seed
    print(f"seed {seed}", flush=True)
    effort = QUICK if given.quick else Effort()
    with at_work(1 if given.only else given.workers, given.cluster) as workers:
        result = study(seed, given.count, workers, given.only, True, effort, given.kinds, given.folder)
    print(result.table(given.worst))


if __name__ == "__main__":
    # under their own name workers, and readers of a folder, find the outcomes
    from tests import accuracy

    accuracy.main()
