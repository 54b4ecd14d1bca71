"""Zeros of a realisation of Markov parameters, and their gradients."""

from __future__ import annotations

import numpy as np

from compensator_theory.errors import IllConditionedError, InputError
from rcac_numeric.arrays._array_types import Array, ComplexArray


def realised_zeros(H: Array, order: int) -> ComplexArray:
    """The zeros of H_0 + H_1/q + ... realised with `order` states, H_0 invertible.

    det (U' (K_1 - K_0 F K_0) V - q U' K_0 V) = 0,  K_0 ~ U S V',  F = E_u H_0^-1 E_y'

    These are the eigenvalues of A - B H_0^-1 C of the eigensystem realisation, in which the square
    roots of the singular values cancel. E_u and E_y' pick the first block.
    """
    return _Pencil(H, order).solved()[0]


def zeros_and_gradients(H: Array, order: int) -> tuple[ComplexArray, ComplexArray]:
    """Those zeros, shape (n,), and the derivative of each by each entry of H.

    First-order perturbation of the generalised eigenvalues, the turning of the subspaces U and V
    with K_0 counted.
    """
    pencil = _Pencil(H, order)
    zeros, left, right = pencil.solved()
    gradients = [
        pencil.gradient(zero, left[:, i], right[:, i]) for i, zero in enumerate(zeros.tolist())
    ]
    return zeros, np.array(gradients).reshape(len(zeros), *H.shape)


class _Pencil:
    def __init__(self, H: Array, order: int) -> None:
        self.H, self.order = H, order
        self.rows = len(H) // 2
        self.columns = len(H) - 1 - self.rows
        self.K_0, self.K_1 = self._hankel(1), self._hankel(2)
        if order > min(self.K_0.shape):
            raise InputError(
                f"order = {order}, but {len(H)} Markov parameters from the first significant one "
                f"on give a Hankel matrix of rank {min(self.K_0.shape)} at most. Estimate more of "
                "them: a larger mu."
            )
        self.U, self.s, Vt = np.linalg.svd(self.K_0)
        self.V = Vt.T
        if order and not self.s[order - 1] > 0:
            raise InputError(
                f"order = {order}, but the Hankel matrix has rank {np.count_nonzero(self.s)}; "
                "lower it."
            )
        l_ = H.shape[1]
        self.inverse = np.linalg.inv(H[0])
        self.F = np.zeros((self.K_0.shape[1], self.K_0.shape[0]))
        self.F[:l_, :l_] = self.inverse
        self.Q = self.K_1 - self.K_0 @ self.F @ self.K_0

    def _hankel(self, first: int) -> Array:
        H = self.H
        return np.asarray(
            np.block([[H[first + i + j] for j in range(self.columns)] for i in range(self.rows)])
        )

    def solved(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Zeros, and the left and right eigenvectors w, v of S^-1/2 (.) S^-1/2, as columns."""
        n = self.order
        root = np.sqrt(self.s[:n])
        M = (self.U[:, :n].T @ self.Q @ self.V[:, :n]) / np.outer(root, root)
        zeros, v = np.linalg.eig(M)
        if n and 1 / np.linalg.cond(v) < np.finfo(float).eps:
            raise IllConditionedError(
                "two zeros of the identified model coincide to rounding, so that their "
                "uncertainty has no first order; change the order or record more data."
            )
        w = np.linalg.inv(v).T if n else v
        zeros, v, w = (np.asarray(a, dtype=np.complex128) for a in (zeros, v, w))
        return zeros, w / root[:, None], v / root[:, None]

    def gradient(self, zero: complex, w: ComplexArray, v: ComplexArray) -> ComplexArray:
        """The gradient of a zero by H; w' S v = 1."""
        n, K_0 = self.order, self.K_0
        U_1, U_2, V_1, V_2 = self.U[:, :n], self.U[:, n:], self.V[:, :n], self.V[:, n:]
        l_, r = U_1 @ w, V_1 @ v
        by_K_1 = np.outer(l_, r)
        by_K_0 = -np.outer(l_, self.F @ (K_0 @ r)) - np.outer(self.F.T @ (K_0.T @ l_), r)
        by_K_0 = by_K_0 - zero * by_K_1
        # U_1 turns by U_2 P, V_1 by V_2 R; both follow from the perturbed singular equations.
        rest = self.Q - zero * K_0
        g, m = U_2.T @ (rest @ r), V_2.T @ (rest.T @ l_)
        s, t = self.s[:n], self.s[n:]
        common = len(t)
        gaps_U, gaps_V = _gaps(s, t, len(g)), _gaps(s, t, len(m))
        if n and min(gaps_U.min(initial=1.0), gaps_V.min(initial=1.0)) <= 0:
            raise IllConditionedError(
                f"order = {n} cuts between two equal singular values; choose another order."
            )
        alpha = np.outer(g, s * w) / gaps_U
        beta = np.outer(m, s * v) / gaps_V
        alpha[:common] += np.outer(t * m[:common], v) / gaps_U[:common]
        beta[:common] += np.outer(t * g[:common], w) / gaps_V[:common]
        by_K_0 = by_K_0 + U_2 @ alpha @ V_1.T + U_1 @ beta.T @ V_2.T
        return self._collected(by_K_0, by_K_1, l_, r)

    def _collected(
        self, by_K_0: ComplexArray, by_K_1: ComplexArray, l_: ComplexArray, r: ComplexArray
    ) -> ComplexArray:
        width = self.H.shape[1]
        gradient = np.zeros(self.H.shape, dtype=np.complex128)
        for i in range(self.rows):
            for j in range(self.columns):
                block = np.s_[i * width : (i + 1) * width, j * width : (j + 1) * width]
                gradient[1 + i + j] += by_K_0[block]
                gradient[2 + i + j] += by_K_1[block]
        left = self.inverse.T @ (self.K_0.T @ l_)[:width]
        right = self.inverse @ (self.K_0 @ r)[:width]
        gradient[0] = np.outer(left, right)
        return gradient


def _gaps(chosen: Array, dropped: Array, count: int) -> Array:
    """Differences of squares of kept singular values and `count` dropped ones, padded by 0."""
    padded = np.concatenate([dropped, np.zeros(count - len(dropped))])
    return np.asarray(chosen**2 - padded[:, None] ** 2)
