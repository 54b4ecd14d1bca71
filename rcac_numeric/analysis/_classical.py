"""Gain, phase and delay margins of a discrete loop, each verified by poles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import compensator_theory as exact
from compensator_theory import figures
from compensator_theory.errors import InputError
from rcac_numeric.analysis._boundaries import (
    StabilityBoundary,
    delay_boundary,
    gain_boundary,
    gain_crossovers,
    phase_boundary,
    phase_crossovers,
)
from rcac_numeric.analysis._closed_loop import OTHER_SIGN, ClosedLoop
from rcac_numeric.analysis._disk import DiskMargin, disk_margin_of
from rcac_numeric.analysis._loop_analysis import attempted
from rcac_numeric.analysis._opened_loop import OpenedLoop, broken_loop, read_beside
from rcac_numeric.arrays._array_types import Array
from rcac_numeric.arrays._showing import notebook_of
from rcac_numeric.arrays._values import Result
from rcac_numeric.plants._foreign import agreed_times, plant_of


@dataclass(frozen=True, eq=False)
class Margins(Result):
    """The stability margins of a loop, with their verification.

    Attributes
    ----------
    loop : OpenedLoop
    is_stable : bool
        Whether the nominal loop is stable, as `ClosedLoop.is_stable`. An unstable loop has no
        margins: they are None.
    spectral_radius : float
        Of the nominal loop, from computed eigenvalues.
    gain_up, gain_down : StabilityBoundary or None
        The nearest factors above and below 1 by which L may be multiplied before a pole reaches
        the unit circle; infinite and 0 where there is none. Of a loop that is stable without
        gain, or unstable with any less, gain_down shows which.
    phase_lag, phase_lead : StabilityBoundary or None
        The least turn of L, in degrees within (0, 360), at positive frequencies backward (lag) and
        forward (lead); infinite without a gain crossover. Table 5.1's PM is a lag.
    delay : StabilityBoundary or None
        The least additional delay, in steps, at which a pole reaches the unit circle:
        min over the gain crossovers of lag / omega, as in Table 5.1. Where abs(L(-1)) > 1 that is
        not the whole truth, and whole steps decide; see `StabilityBoundary.jumps`.
    disk : DiskMargin or None
        None for an unstable loop, and without `disk=True`.
    gain_crossovers, phase_crossovers : arrays
        All omega in [0, pi] with abs(L) = 1, and with L real and negative; rad/sample.
    sample_time : float or None
        In seconds.
    """

    loop: OpenedLoop
    is_stable: bool
    spectral_radius: float
    gain_up: StabilityBoundary | None
    gain_down: StabilityBoundary | None
    phase_lag: StabilityBoundary | None
    phase_lead: StabilityBoundary | None
    delay: StabilityBoundary | None
    disk: DiskMargin | None
    gain_crossovers: Array
    phase_crossovers: Array
    sample_time: float | None

    @property
    def phase(self) -> StabilityBoundary | None:
        """The smaller of lag and lead: the usual phase margin, at most 180 degrees."""
        if self.phase_lag is None or self.phase_lead is None:
            return None
        return min(self.phase_lag, self.phase_lead, key=lambda b: b.value)

    @property
    def delay_time(self) -> float | None:
        """The delay margin in seconds; None without a sample time or without a margin."""
        if self.delay is None or self.sample_time is None:
            return None
        return self.delay.value * self.sample_time

    @property
    def worst_gap(self) -> float:
        """Largest distance from 1 of the pole radius at a margin: the verification error."""
        margins = (self.gain_up, self.gain_down, self.phase, self.delay)
        return max(
            (
                abs(b.radius_at - 1)
                for b in margins
                if b is not None and b.is_reached and not b.jumps
            ),
            default=0.0,
        )

    def __str__(self) -> str:
        if not self.is_stable:
            return (
                f"The loop is unstable, spectral radius {self.spectral_radius:.6g}: it has no "
                f"margins.{OTHER_SIGN * self.loop.has_stable_opposite}"
            )
        assert self.gain_up is not None
        assert self.gain_down is not None
        assert self.phase_lag is not None
        assert self.phase_lead is not None
        assert self.delay is not None
        seconds = "" if self.delay_time is None else f" = {self.delay_time:.6g} s"
        lines = [
            f"gain   up {self.gain_up.value:.6g}{_at(self.gain_up)}, "
            f"down {self.gain_down.value:.6g}{_at(self.gain_down)}",
            f"phase  lag {self.phase_lag.value:.6g} deg{_at(self.phase_lag)}, "
            f"lead {self.phase_lead.value:.6g} deg{_at(self.phase_lead)}",
            f"delay  {self.delay.value:.6g} steps{seconds}{_at(self.delay)}",
            *([] if self.disk is None else [f"disk   {self.disk}"]),
            f"verified: at each margin a pole is on the unit circle within {self.worst_gap:.1e}",
        ]
        return "\n".join(lines)

    def _sheet(self) -> Any:
        from rcac_numeric.reports._check import margins_sheet

        return margins_sheet(self)

    def _repr_html_(self) -> str:
        """Return the notebook view: the table of margins and the Nyquist curve."""
        return notebook_of(self._sheet(), self.plot)

    def plot(self, view: str = "all", **options: Any) -> figures.Figure:
        """Plot the Nyquist curve and the Bode diagram of L with the margins marked.

        Parameters
        ----------
        view : {"all", "nyquist", "bode", "disk"}
            The first two together, one of them, or the gains and turns of phase that the disk
            margin says may change together.
        ax : matplotlib Axes or sequence of Axes, optional
            Where it is drawn instead of in a new figure: two pairs of axes for Bode's plot, three
            for "all", one for the others.
        width : float
            Of the figure in inches; 3.5 fits the column of a journal.

        Returns
        -------
        matplotlib.figure.Figure
            Not attached to a window.

        Raises
        ------
        InputError
            Where the view is none of these or there is no disk margin to show, `ax` has not as
            many axes, or the figure is narrower than 3 inches.

        Examples
        --------
        >>> import control
        >>> from rcac_numeric import stability_margins
        >>> margins = stability_margins(control.tf([0.5], [1, -1], True), feedback=-1)
        >>> [axis.get_title() for axis in margins.plot("bode").axes]
        ['gain margin 4 at 3.14', 'phase margin 75.5 degrees at 0.505']
        """
        from rcac_numeric.plots._margins import plot_margins

        return plot_margins(self, view, **options)


def stability_margins(
    plant: Any,
    compensator: Any = None,
    *,
    feedback: int | None = None,
    variable: str | None = None,
    at: str = "u",
    channel: int = 0,
    sample_time: float | None = None,
    disk: bool = True,
) -> Margins:
    """Compute the margins of a loop with a fixed controller, opened at one scalar signal.

    Crossovers are roots, never points of a grid, and every margin is to the nearest
    boundary of stability in its direction, also for conditionally stable loops: whether a
    crossing ends stability is decided by the poles of the perturbed loop, which are kept.

    Parameters
    ----------
    plant : Run, ClosedLoop, Plant, or transfer function
        Of a run it is the loop of its last controller. A text, an expression of SymPy, a system of
        python-control or SciPy, or whatever else `compensator_theory.transfer_function` reads, is
        the scalar plant G in discrete time, alone the loop itself. A text or a transfer function
        in s, with a dead time or without, is sampled with a hold where `sample_time` is given.
        (`compensator_theory.stability_margins` has the margins of a loop in s.)
    compensator : Compensator, or transfer function, optional
        G_c, 1 by default; none beside a run or a closed loop, which has its own.
    feedback : {+1, -1}
        The sign f of the loop 1 - f G G_c; for the usual loop 1 + G G_c it is -1. It may be left
        out beside a Compensator, which computes u = G_c y, and is left out of a closed loop.
    variable : str, optional
        Of the plant; default: evident.
    at : {"u", "y"}, channel : int
        Where the loop of a `Plant` is opened; its other channels stay closed.
    sample_time : float, optional
        In seconds; taken from the system, plant or compensator that has one. A plant in s needs it.
    disk : bool
        Whether the disk margin is found too.

    Raises
    ------
    InputError
        Where the loop is not scalar, not in discrete time, has abs(L) = 1 at every frequency, no
        sign or one that its compensator was not designed for, or another sample time than the one
        that was given.
    ImproperError
        Where the opened loop is not well posed.

    Notes
    -----
    The text's tables count the phase as a lag in [0, 360) degrees and DM = PM in radians over
    omega. Table 5.2 calls seconds steps: 129.12 degrees at 0.3708 rad/s are 6.08 s, which are 60.8
    steps of 0.1 s.

    Examples
    --------
    >>> from rcac_numeric import ClosedLoop, Compensator, stability_margins, standard_plant
    >>> loop = ClosedLoop(
    ...     standard_plant("1/(q - 2)"), Compensator(past_u=[[[-1.0]]], past_y=[[[0.0]], [[-2.5]]]))
    >>> margins = stability_margins(loop)     # q^2 - q - 2 + 2.5 gain: stable for 0.8 < gain < 1.2
    >>> round(margins.gain_down.value, 9), round(margins.gain_up.value, 9)
    (0.8, 1.2)
    >>> margins = stability_margins("1/(q - 2)", "5/(2*(q + 1))", feedback=-1)  # the same loop
    >>> round(margins.gain_up.value, 9)
    1.2
    >>> margins = stability_margins("2*exp(-3*s)/(10*s + 1)", feedback=-1, sample_time=0.5)
    >>> round(margins.gain_up.value, 3)
    2.735
    """
    if _is_to_be_sampled(plant, sample_time, variable):
        plant = plant_of(plant, sample_time=sample_time, variable=variable)
        compensator, variable = 1 if compensator is None else compensator, None
        if isinstance(compensator, str | int | float):
            compensator = read_beside(compensator)
    opened = broken_loop(
        plant, compensator, at=at, channel=channel, feedback=feedback, variable=variable
    )
    parts = [plant.plant, plant.compensator] if isinstance(plant, ClosedLoop) else plant
    parts = list(parts) if isinstance(parts, list | tuple) else [parts]
    if compensator is not None:
        parts.append(compensator)
    sample_time = agreed_times(parts, sample_time)
    gains, phases = gain_crossovers(opened), phase_crossovers(opened)
    radius = opened.radius()
    stable = opened.is_stable
    return Margins(
        loop=opened,
        is_stable=stable,
        spectral_radius=radius,
        gain_up=gain_boundary(opened, phases, up=True) if stable else None,
        gain_down=gain_boundary(opened, phases, up=False) if stable else None,
        phase_lag=phase_boundary(opened, gains, lead=False) if stable else None,
        phase_lead=phase_boundary(opened, gains, lead=True) if stable else None,
        delay=delay_boundary(opened, gains) if stable else None,
        disk=disk_margin_of(opened) if stable and disk else None,
        gain_crossovers=gains,
        phase_crossovers=phases,
        sample_time=None if sample_time is None else float(sample_time),
    )


def _is_to_be_sampled(plant: Any, sample_time: float | None, variable: str | None) -> bool:
    """Whether a plant is a text or a transfer function in s; one with a dead time needs a time."""
    if not isinstance(plant, str | exact.TransferFunction | exact.DelayedTransferFunction):
        return False
    try:
        G = exact.transfer_function(plant, variable)
    except InputError:  # the reader of loops refuses it with its own reason
        return False
    if sample_time is None and isinstance(G, exact.DelayedTransferFunction):
        raise InputError(
            "the loop has a dead time and is in continuous time; give the period of a hold, as in "
            "sample_time=0.1, or take compensator_theory.stability_margins, which answers it "
            "exactly."
        )
    return sample_time is not None and G.time == "continuous"


def _at(boundary: StabilityBoundary) -> str:
    return f" at {boundary.frequency:.6g} rad/sample" if boundary.is_reached else ""


def channel_margins(
    loop: ClosedLoop, sample_time: float | None = None, *, disk: bool = True
) -> tuple[dict[str, Margins], dict[str, str]]:
    """Return the margins at each component of u, or the reason why there are none.

    The default sample time is that of the plant.
    """
    sample_time = agreed_times([loop.plant, loop.compensator], sample_time)
    margins_of, reasons = {}, {}
    for i in range(loop.plant.l_u):
        name = "u" if loop.plant.l_u == 1 else f"u{i + 1}"
        margins, reason = attempted(
            partial(stability_margins, loop, channel=i, sample_time=sample_time, disk=disk)
        )
        if margins is None:
            reasons[f"margins at {name}"] = reason
        else:
            margins_of[name] = margins
    return margins_of, reasons
