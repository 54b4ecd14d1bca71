"""The strict bounded real lemma in discrete time: a matrix P, and the exact check of P."""

from __future__ import annotations

from dataclasses import dataclass

import flint

from compensator_theory.matrices._definiteness import is_positive_definite
from compensator_theory.polynomials._ball_precision import ball_precision

BITS = 448
"""Bits of the balls whose midpoints the doubling takes."""

COARSE = 128
"""Bits of the balls for the size of the states."""

DOUBLINGS = 60
"""Largest number of doublings: 2^60 steps."""

SETTLED = flint.arb(2) ** -300
"""Relative change of the diagonal of P below which the doubling ends."""


@dataclass(frozen=True)
class GainBound:
    r"""The bound :math:`T(z)^* T(z) < R` on the circle abs(z) = rate, T(z) = C (zI - A)^-1 B + D.

    For R = I and rate = 1 it is an H-infinity norm below 1. It holds with every pole of A inside
    that circle if and only if there is P > 0 with

    .. math:: \begin{bmatrix} a^2 P - A'PA - a^2 C'C & -A'PB - a^2 C'D \\
              -B'PA - a^2 D'C & a^2 (R - D'D) - B'PB \end{bmatrix} > 0, \qquad a = \mathrm{rate}

    Attributes
    ----------
    A, B, C, R : flint.fmpq_mat
        Sizes n x n, n x m, p x n and m x m; R symmetric and positive definite.
    rate : flint.fmpq
    D : flint.fmpq_mat or None
        p x m; None for zero.

    Notes
    -----
    Source: K. Zhou, J. C. Doyle, K. Glover, Robust and Optimal Control (1996), lemma 21.9. P > 0
    implies the bound and stability for every realisation; the converse holds for every strict one.
    """

    A: flint.fmpq_mat
    B: flint.fmpq_mat
    C: flint.fmpq_mat
    R: flint.fmpq_mat
    rate: flint.fmpq
    D: flint.fmpq_mat | None = None

    def matrix(self, P: flint.fmpq_mat) -> flint.fmpq_mat:
        """Return the matrix of the lemma, (n + m) x (n + m)."""
        n, m, square = self.A.nrows(), self.B.ncols(), self.rate**2
        rows = self.A.transpose() * P
        inner = P * square - rows * self.A - (self.C.transpose() * self.C) * square
        mixed = rows * self.B
        outer = self.R * square - self.B.transpose() * P * self.B
        if self.D is not None:
            mixed += (self.C.transpose() * self.D) * square
            outer -= (self.D.transpose() * self.D) * square
        entries = []
        for row, beside in zip(inner.tolist(), mixed.tolist(), strict=True):
            entries += row + [-entry for entry in beside]
        for beside, row in zip(mixed.transpose().tolist(), outer.tolist(), strict=True):
            entries += [-entry for entry in beside] + row
        return flint.fmpq_mat(n + m, n + m, entries)

    def is_proved_by(self, P: flint.fmpq_mat) -> bool:
        """Whether P is positive definite, and the matrix of the lemma as well; exact."""
        n = self.A.nrows()
        if (P.nrows(), P.ncols()) != (n, n) or P.transpose() != P:
            return False
        return is_positive_definite(P) and is_positive_definite(self.matrix(P))

    def certificate(
        self, slacks: tuple[float, ...] = (1e-9, 1e-16, 1e-24)
    ) -> flint.fmpq_mat | None:
        """Return a P of dyadic rationals that proves the bound, or None.

        P solves the Riccati equation of the lemma with C'C + slack W^-1 in place of C'C, W the
        diagonal of the reachability Gramian: what the slack adds is relative to R, whatever the
        units of the states are. None says nothing about the bound.
        """
        sizes = self._reached() if is_positive_definite(self._remaining()) else None
        for slack in slacks:
            solutions = None if sizes is None else self._solutions([slack / w for w in sizes], None)
            P = None if solutions is None else _rational(solutions[1])
            if P is not None and self.is_proved_by(P):
                return P
        return None

    def largest_certificate(
        self, slacks: tuple[float, ...] = (1e-9, 1e-16, 1e-24)
    ) -> flint.fmpq_mat | None:
        """Return a P of dyadic rationals near the largest solution, or None.

        x'Px is then nearly the least supply sum a^(2 (N - k)) (v'Rv - y'y) that brings the state
        from 0 to x, so that {x: x'Px <= c} is the smallest set of this kind that holds what a
        supply of c reaches. Its inverse Q solves Q = A Q (I - C'C Q)^-1 A' + B R^-1 B' + slack W.
        """
        sizes = self._reached() if is_positive_definite(self._remaining()) else None
        for slack in slacks:
            solutions = None if sizes is None else self._solutions(None, [slack * w for w in sizes])
            if solutions is None:
                continue
            with ball_precision(BITS):
                try:
                    P = _rational((-solutions[0]).inv())
                except ZeroDivisionError:  # its ball holds a singular matrix
                    continue
            if self.is_proved_by(P):
                return P
        return None

    def _remaining(self) -> flint.fmpq_mat:
        """Return R - D'D."""
        return self.R if self.D is None else self.R - self.D.transpose() * self.D

    def _reached(self) -> list[flint.arb] | None:
        """Return the diagonal of sum A^k B R^-1 B'A'^k, 1 for zero; None where it diverges."""
        n = self.A.nrows()
        with ball_precision(COARSE):
            scale = flint.arb(1) / flint.arb(self.rate)
            A, B = (flint.arb_mat(self.A) * scale).mid(), flint.arb_mat(self.B) * scale
            W = (B * flint.arb_mat(self.R.inv()) * B.transpose()).mid()
            for _ in range(DOUBLINGS):
                added = (A * W * A.transpose()).mid()
                W, A = (W + added).mid(), (A * A).mid()
                if all(added[i, i] <= W[i, i] / 1000 for i in range(n)):
                    return [W[i, i] if W[i, i] > 0 else flint.arb(1) for i in range(n)]
        return None

    def _solutions(
        self, slack: list[flint.arb] | None, input_slack: list[flint.arb] | None
    ) -> tuple[flint.arb_mat, flint.arb_mat] | None:
        """Return -Q and P by one doubling: P = A'P (I - B R^-1 B'P)^-1 A + C'C + slack.

        Q is the solution of the dual equation; the one of both with a slack has converged. With D,
        A + B (R - D'D)^-1 D'C is in the place of A, R - D'D in that of R, and
        C'(I + D (R - D'D)^-1 D') C in that of C'C.

        Source: E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, Linear Algebra Appl. 396 (2005) 55-80.
        """
        n = self.A.nrows()
        with ball_precision(BITS):
            identity = _diagonal([flint.arb(1)] * n)
            scale = flint.arb(1) / flint.arb(self.rate)
            A, B = flint.arb_mat(self.A) * scale, flint.arb_mat(self.B) * scale
            C, inverse = flint.arb_mat(self.C), flint.arb_mat(self._remaining().inv())
            H = C.transpose() * C
            if self.D is not None:
                cross = flint.arb_mat(self.D).transpose() * C
                A += B * inverse * cross
                H += cross.transpose() * inverse * cross
            G = -(B * inverse * B.transpose())
            if slack is not None:
                H += _diagonal(slack)
            if input_slack is not None:
                G -= _diagonal(input_slack)
            G, H, A = G.mid(), H.mid(), A.mid()
            for _ in range(DOUBLINGS):
                try:
                    within = (identity + G * H).inv().mid()
                except ZeroDivisionError:  # its ball holds a singular matrix
                    return None
                forward = within * A
                added = (A.transpose() * H * forward).mid()
                reached = (A * within * G * A.transpose()).mid()
                G = (G + (reached + reached.transpose()) / 2).mid()
                H = (H + (added + added.transpose()) / 2).mid()
                A = (A * forward).mid()
                grown, whole = (added, H) if input_slack is None else (reached, -G)
                if not all(whole[i, i] > 0 for i in range(n)):
                    return None
                if all(abs(grown[i, i]) <= SETTLED * whole[i, i] for i in range(n)):
                    return G, H
        return None


def _diagonal(entries: list[flint.arb]) -> flint.arb_mat:
    matrix = flint.arb_mat(len(entries), len(entries))
    for i, entry in enumerate(entries):
        matrix[i, i] = entry
    return matrix


def _rational(matrix: flint.arb_mat) -> flint.fmpq_mat:
    """Return the midpoints above the diagonal as a symmetric rational matrix."""
    n = matrix.nrows()
    entries = [matrix[min(i, j), max(i, j)].mid().fmpq() for i in range(n) for j in range(n)]
    return flint.fmpq_mat(n, n, entries)
