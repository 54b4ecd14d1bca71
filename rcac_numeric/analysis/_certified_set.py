"""A set of coefficients in which no motion destabilises the loop, proved exactly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np
from flint import fmpq, fmpq_mat
from numpy.typing import ArrayLike

from compensator_theory import figures
from compensator_theory._few_lines import in_few_lines
from compensator_theory.errors import IllConditionedError, InputError, NoSolutionError
from compensator_theory.polynomials._budget import ask
from compensator_theory.stability._bounded_real_lemma import GainBound
from rcac_numeric.analysis._ellipsoids import largest_for_matrices
from rcac_numeric.analysis._moving_gains import (
    InputGains,
    PerturbedLoop,
    RoundedLoop,
    centered_loop,
    input_gains,
    perturbed_loop,
)
from rcac_numeric.analysis._regressor_system import regressor_system
from rcac_numeric.analysis._stability import is_schur_stable
from rcac_numeric.arrays._array_types import Array, ComplexArray
from rcac_numeric.arrays._showing import notebook_of, report_of, summary_of
from rcac_numeric.arrays._validation import instance_of, number, one_of
from rcac_numeric.arrays._values import Result
from rcac_numeric.controllers._bounds import CertifiedBounds, coefficient_names
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._structure import Structure
from rcac_numeric.plants._foreign import agreed_times, linear_plant
from rcac_numeric.plants._linear import Plant
from rcac_numeric.plants._schedules import PlantSchedule

SHAPES = ("prior", "volume")
MARGINS = (1e-4, 1e-3, 1e-2, 0.1)  # shares of the radius that the exact check may cost
ALTERNATIONS = 2  # between the ellipsoid and the multipliers of gains that move
CAPPED = 0.98  # least norm that is scaled to 1; below it the caps bound the set
CAP = 3.0  # of the largest coefficient of a signal: half of the longest interval
DEPENDENT = 1e-9  # of the largest singular value, below which a direction counts as dependent
SMALL, TERMS = 1e-3, 8  # of a direction: entries that are left out, and those written at most
RATES = (1.0, 0.99, 0.98, 0.95, 0.9, 0.8)
Storage = tuple[tuple[Fraction, ...], ...]


@dataclass(frozen=True, eq=False)
class CertifiedMember(Result):
    """One plant of a certified set with its certificate.

    Attributes
    ----------
    name : str
    plant : Plant
    P : tuple of tuples of Fraction, n x n
        Of the bounded real lemma: x'Px decreases at every step, whatever theta in the set is. x is
        the state of the plant, then past u, y and derived signals, and those of a fixed
        compensator in parallel.
    multipliers : array, shape (gains,)
        Scalings of the gains that move beside theta: of limits, then of the plant's inputs. Empty
        where none moves.
    """

    name: str
    plant: Plant
    P: Storage = field(repr=False)
    multipliers: Array = field(default_factory=lambda: np.zeros(0), repr=False)


@dataclass(frozen=True, eq=False)
class CertifiedSet(Result):
    """An ellipsoid of coefficients: theta may move in it in any way, and the loop stays stable.

    {center + factor v, abs(v) <= 1}. Every sequence theta(k) in it, whatever made it, leaves the
    loop uniformly exponentially stable on every member, if T(z)* M T(z) < R on the unit circle,
    with T from the intercalated injection to the regressor in the loop of `center`, and
    factor factor' = M (x) R^-1. `is_verified` proves that in exact arithmetic.

    Attributes
    ----------
    structure : Structure
    fixed : Compensator or None
        In parallel.
    center : array, shape (l_theta,)
        theta_0 of the settings.
    regressor_factor : array, shape (l_phi, l_phi)
        Lower triangular; times its transpose it is M.
    input_scale : array, shape (l_u,)
        Powers of two; R = diag(input_scale)^-2.
    rate : float
        x(k) decays as rate^k or faster.
    shape : {"prior", "volume", "tail"}
        In which sense the ellipsoid is the largest; "tail": it holds the thetas of a run.
    members : tuple of CertifiedMember
        The plants, the nominal one first.
    uncovered : tuple of str
        What the proof does not cover.
    dependent : array, shape (directions, l_phi)
        Directions of theta that move no pole: entries of the regressor depend on each other. The
        set is capped there.
    input_gain : (float, float)
        Between which the gain at each input of the plants moves in any way beside theta.
    limit_share : float
        Limits apply at least this share of each u, in any way.

    Notes
    -----
    Source: small gain with one storage function (strict bounded real lemma) for the intercalated
    injection (4.14)-(4.18). Along a direction of `dependent` stability needs no bound.
    """

    _REST: ClassVar[str] = "report() has all of it"

    structure: Structure
    fixed: Compensator | None
    center: Array
    regressor_factor: Array
    input_scale: Array
    rate: float
    shape: str
    members: tuple[CertifiedMember, ...]
    uncovered: tuple[str, ...]
    dependent: Array
    input_gain: tuple[float, float] = (1.0, 1.0)
    limit_share: float = 1.0

    @cached_property
    def factor(self) -> Array:
        """The lower triangular factor of the ellipsoid, shape (l_theta, l_theta)."""
        return np.asarray(np.kron(self.regressor_factor, np.diag(self.input_scale)), np.float64)

    @cached_property
    def bounds(self) -> CertifiedBounds:
        """The set as `ControllerSettings.bounds`, which keep theta in it."""
        return CertifiedBounds(self.center, self.factor)

    def radius_of(self, theta: ArrayLike) -> Array:
        """Return abs(factor^-1 (theta - center)): 0 at the center, 1 on the boundary.

        Parameters
        ----------
        theta : array, shape (..., l_theta)
        """
        return self.bounds.radius_of(theta)

    def contains(self, theta: ArrayLike) -> bool:
        """Whether theta, or every theta of an array (..., l_theta), lies in the set."""
        return self.bounds.contains(theta)

    def intervals(self) -> dict[str, tuple[float, float]]:
        """Return (low, high) of each coefficient over the set, by its name.

        Where a name stands for a matrix, as Q_1 of several inputs and outputs, Q_1[i,j] is its
        entry in row i and column j.
        """
        half = np.linalg.norm(self.factor, axis=1)
        low, high = self.center - half, self.center + half
        return dict(zip(entry_names(self.structure), zip(low.tolist(), high.tolist(), strict=True),
                        strict=True))  # fmt: skip

    def decay(self, rates: Sequence[float] = RATES) -> dict[float, float]:
        """Return the share of the radius within which x decays as rate^k, computed in float64.

        0 where the loop of theta_0 itself decays more slowly. `certified_set` with this `rate`
        proves a set of its own.
        """
        shares = {}
        for value in rates:
            rate = _rate(value)
            shares[rate] = min(
                loop.radius(self.regressor_factor, self.input_scale, rate, member.multipliers)
                for member, loop in zip(self.members, self._loops, strict=True)
            )
        return shares

    @cached_property
    def peaks(self) -> dict[str, float]:
        """Norms of T of each member in the metric of the set, in float64; 1 is the bound.

        With gains that move it is the norm of T with their rows and columns, scaled.
        """
        return {
            member.name: loop.peak(
                self.regressor_factor, self.input_scale, self.rate, member.multipliers
            )
            for member, loop in zip(self.members, self._loops, strict=True)
        }

    @property
    def is_verified(self) -> bool:
        """Whether P of every member proves the set, in exact arithmetic, from the fields alone.

        The matrix of the bounded real lemma is formed in rational numbers of the float64 plant,
        center and factor; LDL' in balls proves that it and P are positive definite. Seconds for
        40 coefficients.
        """
        if not self._is_ellipsoid():
            return False
        return all(
            bound is not None and bound.is_proved_by(matrix_of(member.P))
            for member, bound in self._bounds_of_members()
        )

    def _bounds_of_members(self) -> Iterator[tuple[CertifiedMember, GainBound | None]]:
        """Yield each member with the bound that its P proves; None without multipliers."""
        gains = InputGains(*self.input_gain, self.limit_share)
        for member in self.members:
            system = regressor_system(member.plant, self.structure, self.fixed)
            loop = perturbed_loop(system, self.center, gains)
            s = member.multipliers
            if s.shape != (loop.gains,) or not (np.isfinite(s) & (s > 0)).all():
                yield member, None
            else:
                yield member, loop.bound(self.regressor_factor, self.input_scale, s, self.rate)

    def certificate_record(self) -> dict[str, Any]:
        """Return the certificate as a record of JSON that another program checks.

        For every member the matrices of the bounded real lemma, P and S, in the rational numbers of
        the float64 data; ``proofs/recheck.py`` of a checkout evaluates them with Python's standard
        library alone. That the loop has these matrices is not part of the record.

        Returns
        -------
        dict
            As `compensator_theory.certificate_record` returns it.

        Raises
        ------
        InputError
            If a member has no multipliers, so that there is no proof.
        """
        from sympy import ImmutableMatrix, Rational  # SymPy and the exact half, whole

        from compensator_theory.certificates._records import RecordWriter
        from compensator_theory.matrices._flint_matrices import from_flint

        write = RecordWriter(
            "certified set", "P > 0 and the matrix S of the bounded real lemma > 0"
        )
        for k, (member, bound) in enumerate(self._bounds_of_members()):
            if bound is None:
                raise InputError("the multipliers of a member are not positive numbers.")
            P = matrix_of(member.P)
            n, m = int(bound.A.nrows()), int(bound.B.ncols())
            zero = fmpq_mat(bound.C.nrows(), m)
            square = Rational(int(bound.rate.p), int(bound.rate.q)) ** 2
            parts = {"A": bound.A, "B": bound.B, "C": bound.C, "R": bound.R, "P": P,
                     "D": zero if bound.D is None else bound.D, "S": bound.matrix(P)}  # fmt: skip
            for name, part in parts.items():
                write.matrix(f"{name}{k}", from_flint(part))
            unit = ImmutableMatrix.eye(n + m)
            write.matrix(f"E{k}", unit[:n, :])
            write.matrix(f"F{k}", unit[n:, :])
            write.matrix(f"a{k}", square * ImmutableMatrix.eye(n))
            write.matrix(f"b{k}", square * ImmutableMatrix.eye(m))
            A, B, C, D, R, E, F, a, b = (f"{name}{k}" for name in "ABCDREFab")
            write.equation(
                (1, (f"S{k}",)),
                (-1, (f"{E}'", a, f"P{k}", E)),
                (1, (f"{E}'", f"{A}'", f"P{k}", A, E)),
                (1, (f"{E}'", a, f"{C}'", C, E)),
                (1, (f"{E}'", f"{A}'", f"P{k}", B, F)),
                (1, (f"{E}'", a, f"{C}'", D, F)),
                (1, (f"{F}'", f"{B}'", f"P{k}", A, E)),
                (1, (f"{F}'", b, f"{D}'", C, E)),
                (-1, (f"{F}'", b, R, F)),
                (1, (f"{F}'", b, f"{D}'", D, F)),
                (1, (f"{F}'", f"{B}'", f"P{k}", B, F)),
            )
            write.definite(f"P{k}")
            write.definite(f"S{k}")
        return write.record()

    def to_coq(self) -> str:
        """Return the certificate as a file of Coq: P and S of every member are positive definite.

        S is the matrix of the bounded real lemma; that it is made of the member's matrices is an
        equation of the file. ``theorems.SmallGain`` of ``proofs/rocq`` says what follows.

        Raises
        ------
        InputError
            If a member has no multipliers, or the set is not verified.

        See Also
        --------
        compensator_theory.to_coq : The format, and how the file is compiled.
        """
        from compensator_theory.certificates._coq import to_coq  # SymPy and the exact half, whole

        return to_coq(self.certificate_record())

    def _is_ellipsoid(self) -> bool:
        K, scale = self.regressor_factor, self.input_scale
        return bool(
            all(np.isfinite(part).all() for part in (K, scale, self.center))
            and K.shape == (len(self.structure.taps),) * 2
            and scale.shape == (self.structure.l_u,)
            and not np.triu(K, 1).any()
            and (np.diag(K) > 0).all()
            and (scale > 0).all()
            and self.center.shape == (self.structure.l_theta,)
            and 0 < self.rate <= 1
            and 0 <= self.input_gain[0] <= self.input_gain[1] < np.inf
            and 0 <= self.limit_share <= 1
            and self.members
        )

    @cached_property
    def _loops(self) -> list[RoundedLoop]:
        """The loop of `center` on every member."""
        gains = InputGains(*self.input_gain, self.limit_share)
        systems = [regressor_system(m.plant, self.structure, self.fixed) for m in self.members]
        return [centered_loop(system, self.center, gains) for system in systems]

    @property
    def spectral_radius(self) -> float:
        """Largest modulus of a pole of the loops of `center`, in float64."""
        return max(loop.spectral_radius for loop in self._loops)

    def _sheet(self) -> Any:
        from rcac_numeric.reports._certified import certified_sheet

        return certified_sheet(self)

    def report(self) -> str:
        """Return the report: what is not covered, then the proof, members, intervals and decay."""
        return report_of(self._sheet())

    def plot(self, *, width: float = 9.0) -> figures.Figure:
        """Plot the interval of each coefficient, and the share of the radius over the decay.

        Parameters
        ----------
        width : float
            In inches.
        """
        from rcac_numeric.plots._certified import plot_certified_set

        return plot_certified_set(self, width=width)

    @in_few_lines
    def __str__(self) -> str:
        # The verdict before what is not covered: five lines may not reach it behind that.
        title, *uncovered, verdict = summary_of(self._sheet()).split("\n")
        return "\n".join([title, verdict, *uncovered])

    def __repr__(self) -> str:
        names = ", ".join(member.name for member in self.members)
        return f"CertifiedSet({self.structure.name}, l_theta={len(self.center)}, {names})"

    def _repr_html_(self) -> str:
        """The report and the picture as HTML for a notebook."""
        return notebook_of(self._sheet(), self.plot)


def certified_set(
    plant: Any,
    settings: ControllerSettings,
    *,
    uncertainty: Mapping[str, Any] | Sequence[Any] | None = None,
    shape: Literal["prior", "volume"] = "prior",
    rate: float = 1.0,
    input_gain: tuple[float, float] = (1.0, 1.0),
    limit_share: float = 1.0,
) -> CertifiedSet:
    """Find and prove an ellipsoid around theta_0 in which no motion of theta loses the loop.

    T(z)* M T(z) < R for all abs(z) = rate, on the nominal plant and on every other one.

    Parameters
    ----------
    plant : Plant, or a discrete system that `plant_of` reads
        With y that does not follow u at once. A `Plant` of the servo problem has y = e.
    settings : ControllerSettings
        Structure, theta_0, and R_theta for the shape "prior". A fixed compensator in parallel is a
        part of the loop.
    uncertainty : mapping from names to plants, or sequence of plants, optional
        Further plants for which the same set is proved, each with its own certificate. What lies
        between two of them is not covered, nor two changes at once unless they are listed.
    shape : {"prior", "volume"}
        "prior": the ellipsoid that is the largest in the metric of P(0) = R_theta^-1, where RCAC is
        going to move: it minimises tr(M^-1 P(0)). "volume": the one of the largest volume.
    rate : float
        At most 1: abs(x(k)) decays as rate^k or faster.
    input_gain : (low, high)
        The gain at each input of the plants may move between these at every step, in any way,
        while theta moves: an actuator whose effectiveness varies, for instance (0.8, 1.25). It
        counts beside the gain that a plant has.
    limit_share : float
        Limits of the magnitude of u may act as long as they apply at least this share of it: the
        limit over the largest abs(u) that the controller requests. 0 allows limits of any size,
        which a plant that is unstable without control excludes.

    Returns
    -------
    CertifiedSet

    Raises
    ------
    NoSolutionError
        Where theta_0 itself does not stabilise one of the plants, which is named: no set contains
        it then, and `CoefficientBounds` let theta leave it. Likewise at an end of `input_gain` or
        `limit_share`. Where no proof was found.
    ImproperError, BudgetError
        Where y follows u at once, or the loop has too many states.
    InputError
        Where the plant is in continuous time, nonlinear or changes with time, or the controller is
        not one `ControllerSettings`.

    Notes
    -----
    The float64 numbers of plant, theta_0 and factor are dyadic rationals, so that what is proved is
    the loop of exactly these numbers. The matrix P of each plant follows by doubling in 448 bits;
    the radius shrinks by 1e-4 to 0.1 until LDL' in balls proves it.

    Gains that move are further blocks of the small-gain condition, scaled by a multiplier each,
    which is found in float64 and is a part of the certificate. A limit passes s(k) u(k) with s in
    [limit / abs(u), 1]: that is proved, not that abs(u) stays below the peak that `limit_share`
    assumes. Limits of the rate of u are not covered.

    Examples
    --------
    >>> from rcac_numeric import (
    ...     UD, ControllerSettings, TargetModel, certified_set, iir, standard_plant)
    >>> plant = standard_plant("1/(q - 0.9)")
    >>> settings = ControllerSettings(structure=iir(n_c=1), target=TargetModel([0, 1]),
    ...     update=UD(R_theta=100.0), theta_0=[0.2, -0.3])
    >>> region = certified_set(plant, settings, uncertainty={"gain x 1.25": "1.25/(q - 0.9)"})
    >>> region.is_verified, region.contains([0.25, -0.32])
    (True, True)
    >>> [name for name in region.intervals()]
    ['P_1', 'Q_1']
    """
    instance_of(settings, "settings", ControllerSettings)
    one_of(shape, "shape", SHAPES)
    rate = _rate(rate)
    gains = input_gains(input_gain, limit_share)
    plants = _plants(plant, uncertainty)
    structure, fixed, center = settings.structure, settings.fixed, settings.theta_0
    prior = _prior(settings) if shape == "prior" else None
    systems = {name: regressor_system(one, structure, fixed) for name, one in plants.items()}
    loops = {name: centered_loop(system, center, gains) for name, system in systems.items()}
    ask("entries", max(len(loop.A) for loop in loops.values()) ** 3, "the proof of the set")
    corners = _stable_corners(loops, gains, rate)
    responses = np.concatenate([loop.responses(rate) for loop in corners])
    scale = _input_scale(responses, prior)
    caps = _caps(structure, center, scale, prior)
    metric = None if prior is None else _regressor_metric(prior, scale)
    K = largest_for_matrices(np.asarray(responses * scale, np.complex128), caps, metric)
    multipliers = [np.zeros(0)] * len(loops)
    if gains.is_fixed:
        peak = max(loop.peak(K, scale, rate) for loop in loops.values())
        K = K / max(peak, CAPPED)
    else:
        K, multipliers = _beside_gains(loops, K, scale, rate, caps, metric)
    exact_loops = [perturbed_loop(system, center, gains) for system in systems.values()]
    K, storages = proved(exact_loops, K, scale, rate, multipliers)
    return CertifiedSet(
        structure=structure,
        fixed=fixed,
        center=center,
        regressor_factor=K,
        input_scale=scale,
        rate=rate,
        shape=shape,
        members=tuple(
            CertifiedMember(name, one, P, s)
            for (name, one), P, s in zip(plants.items(), storages, multipliers, strict=True)
        ),
        uncovered=_uncovered(settings, len(plants), gains),
        dependent=dependent_directions(responses),
        input_gain=(gains.low, gains.high),
        limit_share=gains.share,
    )


def _rate(value: object) -> float:
    rate = number(value, "rate")
    if not 0 < rate <= 1:
        raise InputError(f"rate = {rate:g} must be positive and at most 1: x decays as rate^k.")
    return rate


def _plants(plant: Any, uncertainty: Any) -> dict[str, Plant]:
    """Return the plants by name, the nominal one first."""
    plants = {"nominal": _fixed_plant(plant, "plant")}
    if uncertainty is None:
        return plants
    if isinstance(uncertainty, Mapping):
        named = [(instance_of(n, "the name of a plant", str), p) for n, p in uncertainty.items()]
    elif isinstance(uncertainty, Sequence) and not isinstance(uncertainty, str):
        named = [(f"plant {i}", p) for i, p in enumerate(uncertainty, start=2)]
    else:
        raise InputError(
            f"uncertainty = {type(uncertainty).__name__} must be a list of plants, or a mapping "
            "from names to plants: the set is proved for each plant of a list, and not for what "
            "lies between them. Design.family holds those of a design."
        )
    for name, one in named:
        if name in plants and one != plants[name]:
            raise InputError(
                f"uncertainty has a plant called {name!r}, as plant itself is; rename it."
            )
        plants[name] = _fixed_plant(one, f"the plant {name!r} of uncertainty")
    agreed_times(list(plants.values()))
    return plants


def _fixed_plant(plant: Any, name: str) -> Plant:
    if isinstance(plant, PlantSchedule):
        raise InputError(
            f"{name} changes with time, and each plant of a certified set has its own certificate, "
            "which does not cover the change. Give its plants as uncertainty={...}."
        )
    return linear_plant(plant, name)


def _prior(settings: ControllerSettings) -> Array:
    """Return P(0), shape (l_theta, l_theta)."""
    weight: float | Array | None = getattr(settings.update, "R_theta", None)
    if weight is None:
        raise InputError(
            f"the update {type(settings.update).__name__} has no R_theta, whose inverse is the "
            'metric of the shape "prior"; use shape="volume".'
        )
    if not isinstance(weight, np.ndarray):
        return np.eye(settings.l_theta) / weight
    d = 1 / np.sqrt(np.diag(weight))
    return np.asarray(np.linalg.inv(weight * np.outer(d, d)) * np.outer(d, d))


def _stable_corners(
    loops: Mapping[str, RoundedLoop], gains: InputGains, rate: float
) -> list[RoundedLoop]:
    """Return the loops with the gains in the middle and at the ends; raise if one is unstable."""
    lost, corners = [], []
    for name, loop in loops.items():
        for words, deltas in gains.corners(loop.inputs):
            corner = loop.held(deltas) if deltas else loop
            corners.append(corner)
            try:
                stable = is_schur_stable(corner.A / rate)
            except IllConditionedError:
                stable = False
            if not stable:
                where = f" with {words}" if words else ""
                lost.append(f"{name}{where} (spectral radius {corner.spectral_radius:.6g})")
    if lost:
        decay = "" if rate == 1 else f" with the decay rate {rate:g}"
        narrower = "" if gains.is_fixed else ", narrow input_gain or raise limit_share"
        raise NoSolutionError(
            f"theta_0 itself does not stabilise the loop{decay} on {', '.join(lost)}, so that no "
            f"set around it is certified. Choose another theta_0, leave these plants out of "
            f"uncertainty{narrower}, or bound theta by CoefficientBounds, which let it leave "
            "theta_0."
        )
    return corners


def _beside_gains(
    loops: Mapping[str, RoundedLoop],
    K: Array,
    scale: Array,
    rate: float,
    caps: Array,
    metric: Array | None,
) -> tuple[Array, list[Array]]:
    """Return K and the multipliers of each loop: multipliers for K, K for them, and again."""
    allowances = {name: loop.allowance(scale, rate) for name, loop in loops.items()}
    multipliers: list[Array] = []
    for repetition in range(ALTERNATIONS + 1):
        multipliers = []
        for name, allowance in allowances.items():
            s = allowance.best_multipliers(K)
            if s is None:
                raise NoSolutionError(
                    f"{name}: stability is not proved for gains that move so far, even with theta "
                    "= theta_0. Narrow input_gain or raise limit_share."
                )
            multipliers.append(s)
        if repetition < ALTERNATIONS:
            points = [
                T for allowance, s in zip(allowances.values(), multipliers, strict=True)
                if (T := allowance.effective(s)) is not None
            ]  # fmt: skip
            K = largest_for_matrices(np.concatenate(points), caps, metric)
    pairs = list(zip(allowances.values(), multipliers, strict=True))
    return K * min(1 / CAPPED, *(allowance.radius(K, s) for allowance, s in pairs)), multipliers


def _input_scale(responses: ComplexArray, prior: Array | None) -> Array:
    """Return the size of a change of each row of Theta relative to the largest, powers of two."""
    inputs = responses.shape[2]
    if inputs == 1:
        return np.ones(1)
    if prior is not None:
        sizes = np.exp(np.log(np.diag(prior)).reshape(-1, inputs).mean(axis=0) / 2)
    else:
        power = (np.abs(responses) ** 2).mean(axis=(0, 2))
        weighted = np.abs(responses) ** 2 / np.where(power > 0, power, 1.0)[None, :, None]
        sizes = 1 / np.sqrt(weighted.mean(axis=(0, 1)).clip(1e-300))
    return np.asarray(np.exp2(np.round(np.log2(sizes / sizes.max()))), np.float64)


def _caps(structure: Structure, center: Array, scale: Array, prior: Array | None) -> Array:
    """Return the largest sqrt(M_ii) for each entry of the regressor, by the size of theta_0."""
    Theta = np.abs(center.reshape(-1, structure.l_u)) / scale
    signals = np.array([tap.signal for tap in structure.taps])
    spread = np.zeros(len(signals))
    if prior is not None:
        spread = (np.sqrt(np.diag(prior)).reshape(-1, structure.l_u) / scale).max(axis=1)
    caps = np.empty(len(signals))
    largest = float(Theta.max(initial=0.0))
    for signal in set(signals):
        rows = signals == signal
        size = float(Theta[rows].max())
        caps[rows] = CAP * (size or float(spread[rows].max()) or largest or 1.0)
    return caps


def _regressor_metric(prior: Array, scale: Array) -> Array:
    """Return Sigma with tr(M^-1 Sigma) = tr((M^-1 (x) R) P(0))."""
    l_u = len(scale)
    blocks = prior.reshape(len(prior) // l_u, l_u, len(prior) // l_u, l_u)
    return np.asarray(np.einsum("iaja,a->ij", blocks, scale**-2.0))


def proved(
    loops: Sequence[PerturbedLoop],
    K: Array,
    scale: Array,
    rate: float,
    multipliers: Sequence[Array],
) -> tuple[Array, list[Storage]]:
    """Shrink K until each loop has a proof; return it and the matrices P."""
    storages: list[fmpq_mat | None] = [None] * len(loops)
    for margin in MARGINS:
        smaller = K * (1 - margin)
        for i, (loop, s) in enumerate(zip(loops, multipliers, strict=True)):
            if storages[i] is None:  # a P of a larger set proves the smaller one
                storages[i] = loop.bound(smaller, scale, s, rate).certificate()
        if all(P is not None for P in storages):
            return smaller, [fractions_of(P) for P in storages if P is not None]
    raise NoSolutionError(
        f"no proof was found for {sum(P is None for P in storages)} of {len(storages)} plants at "
        f"{1 - MARGINS[-1]:g} of the computed radius: the loop of theta_0 is at the edge of "
        "stability. Choose another theta_0 or scale the signals."
    )


def fractions_of(matrix: fmpq_mat) -> Storage:
    """Return a rational matrix as rows of fractions."""
    rows = matrix.tolist() if matrix.nrows() else []
    return tuple(tuple(Fraction(int(e.p), int(e.q)) for e in row) for row in rows)


def matrix_of(rows: Storage) -> fmpq_mat:
    """Return rows of fractions as a square rational matrix; an empty one where they are not."""
    n = len(rows)
    if any(len(row) != n for row in rows):
        return fmpq_mat(0, 0)
    return fmpq_mat(n, n, [fmpq(e.numerator, e.denominator) for row in rows for e in row])


def dependent_directions(responses: ComplexArray) -> Array:
    """Return an orthonormal basis of the directions a with a'T = 0, up to rounding."""
    taps = responses.shape[1]
    rows = responses.transpose(0, 2, 1).reshape(-1, taps)
    stacked = np.concatenate([rows.real, rows.imag])
    size = np.sqrt((stacked**2).mean(axis=0))
    size[size == 0] = 1.0
    _, singular, V = np.linalg.svd(stacked / size, full_matrices=False)
    rank = int((singular > DEPENDENT * singular[0]).sum()) if singular[0] > 0 else 0
    directions = V[rank:] / size
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def _uncovered(settings: ControllerSettings, plants: int, gains: InputGains) -> tuple[str, ...]:
    """Return the conditions that the proof does not cover."""
    limited, amplified = gains.moving()
    among = (
        ""
        if amplified is None
        else f" otherwise than by input gains in [{gains.low:g}, {gains.high:g}]"
    )
    listed = (
        "other plants than the nominal one: give them as uncertainty"
        if plants == 1
        else f"plants beside the {plants} of the list: what lies between two of them, two changes "
        f"at once, and a plant that moves among them{among}"
    )
    if plants == 1 and amplified is not None:
        listed = (
            f"other plants than the nominal one with input gains in [{gains.low:g}, "
            f"{gains.high:g}]: give them as uncertainty"
        )
    limits = (
        "limits of u: at a limit the loop is another one"
        if limited is None
        else f"limits that apply less than {gains.share:g} of u, and limits of its rate"
    )
    entries = [
        limits,
        listed,
        "the plant between its samples, and the rounding of a continuous plant to these samples",
        "performance: the loop is stable in the whole set, and may be poor near its boundary",
    ]
    if any(np.isfinite(signal.limit) for signal in settings.structure.derived):
        entries.insert(1, "limits of integrators: at a limit the loop is another one")
    if settings.k_w > 0:
        entries.append(f"steps before k_w = {settings.k_w}, where u = 0")
    return tuple(entries)


def entry_names(structure: Structure) -> tuple[str, ...]:
    """Return a name of each entry of theta; entries of a matrix have their row and column."""
    base = coefficient_names(structure)[:: structure.l_u]
    words = []
    for i, name in enumerate(base):
        column = [str(base[:i].count(name) + 1)] if base.count(name) > 1 else []
        for row in range(structure.l_u):
            place = ([str(row + 1)] if structure.l_u > 1 else []) + column
            words.append(f"{name}[{','.join(place)}]" if place else name)
    return tuple(words)


def direction_texts(directions: Array, structure: Structure) -> tuple[str, ...]:
    """Return each direction of the regressor as a sum of coefficients, its largest entry 1."""
    base = coefficient_names(structure)[:: structure.l_u]
    words = []
    for direction in directions:
        scaled = direction / direction[np.abs(direction).argmax()]
        order = [i for i in np.argsort(-np.abs(scaled)) if abs(scaled[i]) > SMALL]
        terms = [f"{scaled[i]:+.3g} {base[i]}" for i in order[:TERMS]]
        words.append(" ".join(terms) + (" ..." if len(order) > TERMS else ""))
    return tuple(words)
