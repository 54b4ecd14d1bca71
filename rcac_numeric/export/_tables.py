"""From a controller as data to the sizes and constants of the stand-alone core."""

from __future__ import annotations

import ctypes
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compensator_theory.errors import BudgetError, InputError
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._validation import integer
from rcac_numeric.compiled._callbacks import Failures
from rcac_numeric.compiled._controllers import kernel_arguments
from rcac_numeric.compiled._updates import require_kind
from rcac_numeric.controllers._bounds import CertifiedBounds, ellipsoid_radii, inverse_factor
from rcac_numeric.controllers._compensator import Compensator
from rcac_numeric.controllers._decentralized import Decentralized
from rcac_numeric.controllers._fixed import FixedController
from rcac_numeric.controllers._forgetting import CappedForgetting, SubspaceForgetting
from rcac_numeric.controllers._recursive import UD
from rcac_numeric.controllers._settings import ControllerSettings
from rcac_numeric.controllers._supervision import Supervision
from rcac_numeric.controllers._weights import SignalWeight
from rcac_numeric.plants._saturation import Saturation

# What a controller of the core may need at most: beyond it no microcontroller holds P.
LARGEST_L_THETA = 400
LONGEST = 10_000  # delays, windows, events
REMEMBERED_STEPS = 200  # as in kernel/controller/stored_signals.hpp
KINDS_OF_EVENTS = ("freeze", "resume", "reset", "forgetting", "target")
C_INT, C_LONG = ctypes.c_int32, ctypes.c_int64
Pairs = tuple[tuple[int, int], ...]
Numbers = tuple[float, ...]


@dataclass(frozen=True)
class CoreTables:
    """Everything that the core knows of a controller, in float64; the order is row-major.

    Attributes
    ----------
    what : str
        What the README calls it.
    l_u, l_y, l_r, l_z : int
    derived : of (now, before, pole, limit)
    regressor, channels, filtered : of (source, delay)
    theta_0, U_0, D_0 : numbers
        U_0 column by column above its unit diagonal; empty where P(0) is diagonal.
    order : int
        Of the target models, which are padded to it.
    numerators, denominators : numbers
        Of all target models, one behind the other.
    R_z, R_u : (base, z_squared, nu)
    penalty, noise, past_v, past_e, low, high, rate : numbers, or empty
    normalization : (number of the function, limit, slope)
    bounds : (low, high, sweeps) or None
        With sweeps = 0 entry by entry.
    ellipsoid : CertifiedBounds or None
    forgetting : (short, long, gain, smallest)
    reset : (every, trace_below, growth, short, long)
    events : of (step, number of the kind, value)
    live : bool
        Whether the target model can be replaced while it runs.
    supervision : (growth, limit of abs(z) or 0, patience) or None
    scale : float
        P and the variances are multiplied by it; a power of two.
    """

    what: str
    l_u: int
    l_y: int
    l_r: int
    l_z: int
    derived: tuple[tuple[Numbers, Numbers, float, float], ...]
    regressor: Pairs
    channels: Pairs
    filtered: Pairs
    theta_0: Numbers
    U_0: Numbers
    D_0: Numbers
    order: int
    numerators: Numbers
    denominators: Numbers
    R_z: tuple[Numbers, float, float]
    R_u: tuple[Numbers, float, float]
    penalty: Numbers
    normalization: tuple[int, float, float]
    bounds: tuple[Numbers, Numbers, int] | None
    ellipsoid: CertifiedBounds | None
    past_v: Numbers
    past_e: Numbers
    low: Numbers
    high: Numbers
    rate: Numbers
    lambda_: float
    forgets: bool
    forgetting: tuple[int, int, float, float]
    reset: tuple[int, float, float, int, int]
    noise: Numbers
    events: tuple[tuple[int, int, float], ...]
    k_w: int
    k_update: int
    k_filter: int
    filter_form: bool
    measures_first: bool
    strictly_proper: bool
    adapts: bool
    live: bool
    supervision: tuple[float, float, int] | None = None
    scale: float = 1.0

    @property
    def l_theta(self) -> int:
        """Number of coefficients."""
        return len(self.theta_0)

    @property
    def l_e(self) -> int:
        """Number of measurements and commands together."""
        return self.l_y + self.l_r

    @property
    def rows(self) -> int:
        """Scalar measurements that one step gives the update."""
        return self.l_z + (self.l_u if self.penalty else 0)

    @property
    def reach(self) -> int:
        """The longest delay that is read."""
        return max(1, *(delay for _, delay in (*self.regressor, *self.channels)))

    @property
    def sources(self) -> tuple[int, ...]:
        """The distinct signals that the target-model filter is fed with."""
        return tuple(dict.fromkeys(source for source, _ in self.channels))

    @property
    def fixed_order(self) -> int:
        """The order of the fixed part; 0 where there is none."""
        return len(self.past_v) // self.l_u**2

    @property
    def varying_weights(self) -> bool:
        """Whether a weight follows z."""
        return any(z_squared or nu for _, z_squared, nu in (self.R_z, self.R_u))

    @property
    def upper(self) -> int:
        """Entries of U above its diagonal; C knows no empty array."""
        return max(1, self.l_theta * (self.l_theta - 1) // 2)

    @property
    def power_window(self) -> int:
        """Steps over which z'z is kept."""
        long = self.reset[4] if self.reset[2] > 0 else 0
        return max(self.forgetting[1], long) if self.adapts else 0

    @property
    def output_depth(self) -> int:
        """Steps that each filtered signal is kept."""
        return max(self.order, *(delay for _, delay in self.filtered)) + 1

    @property
    def remembered(self) -> int:
        """Steps that the signals are kept for another target model."""
        return self.reach + REMEMBERED_STEPS + self.order + 1

    def sizes(self, real: str) -> tuple[int, int]:
        """Bytes of `rcac_state` as this machine aligns it, and of the constants."""
        number: Any = ctypes.c_double if real == "float64" else ctypes.c_float
        n, l_u, block, i32, i64 = self.l_theta, self.l_u, self.l_z * self.l_u, C_INT, C_LONG
        fields = [(i32, 5), (i64, 1), (number, l_u)]
        fields += [(number, (l_u + self.l_e + len(self.derived)) * (self.reach + 1) + n)]
        fields += [(number, l_u if self.low else 0)]
        fixed = (l_u + self.l_e) * (self.fixed_order + 2)
        fields += [(number, fixed if self.past_e else 0)]
        if self.adapts:
            fields += [(number, n if real == "float32" else 0), (number, self.upper + n)]
            fields += [(number, len(self.channels) * (self.order + 1 + block * self.output_depth))]
            fields += [(number, 1)]
            if self.live:
                fields += [(number, (self.order + 1) * (block + self.l_z**2))]
                fields += [(number, len(self.sources) * self.remembered)]
            fields += [(i32, 1), (number, self.power_window), (i64, int(self.power_window > 0))]
            fields += [(number, int(self.reset[1] > 0)), (i32, 1), (i64, 5)]
        if self.supervision:
            trouble = type("Trouble", (ctypes.Structure,), {
                "_fields_": [("counts", i64 * 4), ("worst", number)]
            })  # fmt: skip
            looks = 1 + (self.ellipsoid is not None)
            fields += [(trouble, 5), (i64, 1), (number, looks + n + self.l_z + l_u), (i32, 3)]
        members = [(f"_{i}", kind * count) for i, (kind, count) in enumerate(fields) if count]
        state = type("State", (ctypes.Structure,), {"_fields_": members})
        numbers = (
            self.theta_0, self.D_0, self.U_0, self.numerators, self.denominators, self.penalty,
            self.noise, self.past_v, self.past_e,
        )  # fmt: skip
        pairs = len(self.regressor) + len(self.channels) + len(self.filtered) * self.adapts
        count = sum(map(len, numbers))
        if self.ellipsoid is not None:
            count += n + n * (n + 1) // 2 + 2
        constants = ctypes.sizeof(number) * count + 4 * pairs
        return ctypes.sizeof(state), constants

    def operations(self) -> tuple[int, int]:
        """Multiplications, with about as many additions, and divisions of a step at most."""
        n, block = self.l_theta, self.l_z * self.l_u
        control = n + self.l_e * (2 * len(self.derived) + (self.fixed_order + 1) * self.l_u)
        control += self.fixed_order * self.l_u**2
        if not self.adapts:
            return control, 0
        row = 3 * n * (n - 1) // 2 + 7 * n  # f, U and the gain; what each column and theta need
        whitened = 0 if self.rows == 1 else n * (self.rows + 1)
        taps = (self.order + 1) * (1 + self.l_z)
        filtered = len(self.channels) * block * taps
        inflated = len(self.noise) // n * (n * (n - 1) + 3 * n)
        divisions = self.rows * (2 * n + 1) + (n if self.forgets else 0) + len(self.noise) * 2
        projection = 0
        if self.ellipsoid is not None:  # where theta is outside: four cuts
            look = n * (n + 1) // 2 + 2 * n
            projection, divisions = look + 4 * (n * n + 2 * look) + n, divisions + 5
        step = self.rows * (row + whitened) + inflated + projection
        return control + filtered + step, divisions

    def stack(self, real: str) -> int:
        """Approximate stack of a step in bytes: its arrays, and a share for calls and registers.

        The latter as it was measured on a Cortex-M4F in drawn settings; the sum is at most a tenth
        too small and a third too large.
        """
        arrays = (
            3 * self.l_theta + 2 * self.rows + (2 * self.rows**2 if self.varying_weights else 0)
        )
        if self.live:
            arrays = max(arrays, 2 * self.l_z * self.l_u * self.remembered)
        return (8 if real == "float64" else 4) * (arrays + 50 + 10 * self.rows)


def core_tables(
    controller: ControllerSettings | FixedController | Compensator,
    *,
    saturation: Saturation | None = None,
    live_order: int | None = None,
    supervision: Supervision | None = None,
) -> CoreTables:
    """The tables of a controller; settings that the core does not know are refused by name."""
    if isinstance(controller, Compensator):
        controller = FixedController(controller)
    if isinstance(controller, Decentralized):
        raise InputError(
            "a Decentralized is several controllers; export each of its `controllers`, with a "
            "separate prefix."
        )
    if not isinstance(controller, ControllerSettings | FixedController):
        raise InputError(
            f"a {type(controller).__name__} cannot be exported; ControllerSettings, a "
            "FixedController or a Compensator (run.compensator) can."
        )
    adapts = isinstance(controller, ControllerSettings)
    if isinstance(controller, ControllerSettings):
        _require_known(controller, live_order)
        l_z, measures_first = controller.target.l_z, controller.measures_first
        measures_first = measures_first or controller.form == "filter"
        strictly_proper = not any(model.numerator[0].any() for model in controller.targets)
        name = controller.structure.name  # anything, and written into C
        name = name if re.fullmatch(r"[\w +-]{1,40}", name, re.ASCII) else "a table of taps"
        kind = "frozen from step 0" if (0, None) in controller.freeze else "adaptive"
        subject = f"{kind}, {name} of order {controller.structure.n_c}"
    else:
        l_z, strictly_proper = 1, True
        measures_first = bool(controller.compensator.past_y[0].any())
        subject = f"fixed, of order {controller.compensator.n_c}"
        if live_order is not None:
            raise InputError("a fixed compensator has no target model that could be replaced.")
    arguments = kernel_arguments(controller, l_z, Failures())
    if saturation is not None:
        require_kind(saturation, "saturation", (Saturation,), "export")
    bounds_of_u = saturation.bounds(arguments["l_u"]) if saturation else ((), (), ())
    bounds = controller.bounds if isinstance(controller, ControllerSettings) else None
    tables = _read(arguments, live_order, {
        "what": subject, "ellipsoid": bounds if isinstance(bounds, CertifiedBounds) else None,
        "adapts": adapts, "measures_first": measures_first,
        "strictly_proper": strictly_proper,
        "low": _numbers(bounds_of_u[0]), "high": _numbers(bounds_of_u[1]),
        "rate": _numbers(bounds_of_u[2]),
        "supervision": _supervision(supervision, adapts),
    })  # fmt: skip
    _require_sizes(tables)
    return tables


def scaled(tables: CoreTables) -> CoreTables:
    """Scale P and the variances by 2^round(log2(R_theta)/2), for a short exponent.

    R_theta is the inverse of the geometric mean of D(0). The factor is a power of two, so that
    float64 gives the same bits.
    """
    if not tables.adapts:
        return tables
    scale = 2.0 ** round(-sum(map(math.log2, tables.D_0)) / len(tables.D_0) / 2)
    return replace(tables, D_0=tuple(d * scale for d in tables.D_0), scale=scale)


def _read(arguments: dict[str, Any], live_order: int | None, more: dict[str, Any]) -> CoreTables:
    """The kernel's arguments as tables."""
    l_u, l_z = arguments["l_u"], arguments["l_z"]
    n_f = len(arguments["targets"][0][0]) - 1
    order = n_f if live_order is None else max(n_f, integer(live_order, "live_order"))
    padding = [(0, order - n_f), (0, 0), (0, 0)]
    models = [tuple(np.pad(part, padding) for part in pair) for pair in arguments["targets"]]
    low, high, in_metric, sweeps = arguments.get("bounds", ((), (), False, 0))
    past_v, past_e = arguments.get("fixed", ((), ()))
    U_0, D_0 = _factors(arguments["P_0"]) if more["adapts"] else ((), ())
    lambda_ = arguments["forgetting_factor"]
    changes = [value for _, kind, value in arguments["events"] if kind == "forgetting"]
    return CoreTables(
        l_u=l_u,
        l_y=arguments["l_y"],
        l_r=arguments["l_r"],
        l_z=l_z,
        derived=tuple(
            (_numbers(now), _numbers(before), float(pole), float(limit))
            for now, before, pole, limit in arguments["derived"]
        ),
        regressor=tuple(arguments["regressor"]),
        channels=tuple(arguments["channels"]),
        filtered=tuple(arguments["filtered"]),
        theta_0=_numbers(arguments["theta_0"]),
        U_0=U_0,
        D_0=D_0,
        order=order,
        numerators=_numbers(np.stack([numerator for numerator, _ in models])),
        denominators=_numbers(np.stack([denominator for _, denominator in models])),
        R_z=_weight(arguments["R_z"]),
        R_u=_weight(arguments["R_u"]),
        penalty=_numbers(arguments.get("penalty", ())),
        normalization=arguments.get("normalization", (0, 1.0, 1.0)),
        bounds=None
        if not len(low)
        else (_numbers(low), _numbers(high), int(sweeps) if in_metric else 0),
        past_v=_numbers(past_v),
        past_e=_numbers(past_e),
        lambda_=float(lambda_),
        forgets=lambda_ < 1 or any(v < 1 for v in changes) or arguments["forgetting"][1] > 0,
        forgetting=arguments["forgetting"],
        reset=arguments["reset"],
        noise=_numbers(arguments["noise"]),
        events=tuple(
            (int(step), KINDS_OF_EVENTS.index(kind), float(value))
            for step, kind, value in arguments["events"]
        ),
        k_w=arguments["k_w"],
        k_update=arguments["k_update"],
        k_filter=arguments["k_filter"],
        filter_form=arguments["filter_form"],
        live=live_order is not None,
        **more,
    )


def _numbers(values: ArrayLike) -> Numbers:
    return tuple(float(v) for v in np.asarray(values, dtype=np.float64).reshape(-1))


def _weight(value: Any) -> tuple[Numbers, float, float]:
    base, z_squared, nu = value if isinstance(value, tuple) else (value, 0.0, 0.0)
    return _numbers(base), float(z_squared), float(nu)


def _factors(P_0: Array) -> tuple[Numbers, Numbers]:
    """U and D of P(0) = U D U', rounded as `UdUpdate::factorise` rounds them."""
    n = len(P_0)
    P = [[float(v) for v in row] for row in P_0]
    if not np.any(P_0 - np.diag(np.diag(P_0))):
        return (), tuple(P[j][j] for j in range(n))
    U, D = [[0.0] * n for _ in range(n)], [0.0] * n
    for j in range(n - 1, -1, -1):
        D[j] = P[j][j]
        if not D[j] > 0:
            raise InputError("R_theta is so badly conditioned that P(0) has no factors in float64.")
        for i in range(j):
            U[i][j] = P[i][j] / D[j]
        for i in range(j):
            for m in range(i + 1):
                P[m][i] -= U[m][j] * D[j] * U[i][j]
    return tuple(U[i][j] for j in range(n) for i in range(j)), tuple(D)


LEAST_SHARE = 0.9  # share of the radius that the core may lose to its numbers


def ellipsoid_constants(bounds: CertifiedBounds, real: type) -> tuple[Numbers, Numbers, Numbers]:
    """Return center, factor^-1 and (limit, aim) of an ellipsoid in the numbers of the core.

    factor^-1 is packed row by row. In float32 the radius has the errors of float32, and the limit
    is smaller by the radius at which the rounded center lies.
    """
    center: Any = bounds.center.astype(real)
    rows: Any = inverse_factor(bounds).astype(real)
    packed = np.concatenate([row[: i + 1] for i, row in enumerate(rows)])
    share = 1 - float(bounds.radius_of(center.astype(np.float64)))
    limit, aim = (share * radius for radius in ellipsoid_radii(bounds, float(np.finfo(real).eps)))
    if not aim >= LEAST_SHARE:
        raise InputError(
            f"{np.dtype(real)} keeps {max(aim, 0):.2g} of the radius of CertifiedBounds, and "
            f'{LEAST_SHARE} is needed: its axes are too unequal. Export with real = "float64".'
        )
    return _numbers(center), _numbers(packed), (limit, aim)


def whitening(tables: CoreTables) -> tuple[Numbers, Numbers]:
    """R_z and the Cholesky factor L of R_z + R_u, with a penalty's rows, as the kernel rounds."""
    l_z, m = tables.l_z, tables.rows
    R_z, L = ([[0.0] * m for _ in range(m)] for _ in range(2))
    for i in range(l_z):
        for j in range(l_z):
            R_z[i][j] = tables.R_z[0][i * l_z + j]
            L[i][j] = tables.R_u[0][i * l_z + j]
    for i in range(l_z, m):
        R_z[i][i] = 1.0
    L = [[z + u for z, u in zip(*rows, strict=True)] for rows in zip(R_z, L, strict=True)]
    for j in range(m):
        pivot = L[j][j]
        for k in range(j):
            pivot -= L[j][k] * L[j][k]
        if not pivot > 0:
            raise InputError("R_z + R_u is not positive definite in float64.")
        L[j][j] = math.sqrt(pivot)
        for i in range(j + 1, m):
            total = L[i][j]
            for k in range(j):
                total -= L[i][k] * L[j][k]
            L[i][j] = total / L[j][j]
    return _numbers(R_z), _numbers(L)


def _require_known(settings: ControllerSettings, live_order: int | None) -> None:
    """Refuse settings that the core does not know, by name."""

    def refuse(subject: str, instead: str) -> None:
        raise InputError(f"{subject} is not in the stand-alone core; {instead}.")

    update = settings.update
    if type(update) is not UD:
        refuse(f"the update {type(update).__name__}", "export a controller with UD")
    assert isinstance(update, UD)
    if isinstance(update.lambda_, SubspaceForgetting | CappedForgetting):
        name = type(update.lambda_).__name__
        refuse(name, "use a number, a schedule or VariableRateForgetting")
    if settings.learning is not None:
        refuse("DataDriven learning of the target model",
               "export with the identified model, and live_order")  # fmt: skip
    if settings.reflect_poles:
        refuse("reflect_poles, which needs complex roots,", "use bounds on theta")
    for name, value in (("R_z", settings.R_z), ("R_u", settings.R_u)):
        if not isinstance(value, np.ndarray | SignalWeight):
            refuse(f"{name} as a function", "use a number, a matrix or SignalWeight")
    normalization = settings.z_normalization
    if normalization is not None and normalization.function not in ("rational", "root"):
        refuse(f'the normalisation "{normalization.function}", which needs libm,',
               'use "rational" or "root"')  # fmt: skip
    if live_order is not None and settings.target_changes:
        refuse("target_changes beside live_order", "leave one of them out")
    if live_order is not None and settings.k_filter > 0:
        refuse("k_filter > 0 beside live_order", "use k_filter = 0")


def _supervision(supervision: Supervision | None, adapts: bool) -> tuple[float, float, int] | None:
    """The supervision of the core, which reports; a policy that acts is refused by name."""
    if supervision is None:
        return None
    require_kind(supervision, "supervision", (Supervision,), "export")
    if supervision.policy == "off":
        return None
    if not adapts:
        raise InputError("a fixed compensator has no P to supervise; leave supervision out.")
    if supervision.policy != "warn":
        raise InputError(
            f'the policy "{supervision.policy}" is not in the stand-alone core, which reports and '
            "does not "
            'act; use Supervision("warn"), and act on its status in your program.'
        )
    if supervision.jump is not None or supervision.missed != "hold":
        name = "jump" if supervision.jump is not None else 'missed="fallback"'
        raise InputError(f"{name} of Supervision is not in the stand-alone core; leave it out.")
    limit = supervision.limit if math.isfinite(supervision.limit) else 0.0
    return supervision.growth, limit, min(supervision.patience, 2**62)


def _require_sizes(tables: CoreTables) -> None:
    if tables.l_theta > LARGEST_L_THETA:
        raise BudgetError(
            f"l_theta = {tables.l_theta} is above {LARGEST_L_THETA}: the core would keep "
            f"{tables.l_theta**2 // 2} numbers of P."
        )
    sizes: Iterable[tuple[str, int]] = (
        ("the longest delay", tables.reach),
        ("the order of the target model", tables.order),
        ("a window of forgetting or of resets", max(tables.forgetting[1], tables.reset[4])),
        ("the number of scheduled events", len(tables.events)),
        ("sweeps of the bounds", tables.bounds[2] if tables.bounds else 0),
    )
    for name, value in sizes:
        if value > LONGEST:
            raise BudgetError(f"{name} is {value}; the core takes at most {LONGEST}.")
