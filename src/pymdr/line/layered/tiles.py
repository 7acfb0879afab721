"""Systems of a contact by Cholesky's factors in tiles, each too small for a linear algebra library to share among threads.

Such threads wait for one another by spinning: beside other work a system of 700 unknowns then takes 50 times as long.
"""

from __future__ import annotations

import numpy as np

from pymdr.units import FloatArray

_TILE = 48
"""Rows of a tile; OpenBLAS multiplies up to 64 by 64 in the calling thread."""


def solve_positive(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """
    The solution of a symmetric positive definite system.

    Parameters
    ----------
    matrix : ndarray
        Shape (n, n).
    right : ndarray
        Right sides, shape (n, m).

    Examples
    --------
    >>> solve_positive(np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([[3.0], [3.0]])).ravel().round(14).tolist()
    [1.0, 1.0]
    """
    n = right.shape[0]
    count = -(-n // _TILE)
    # the first index is the column of tiles, whose lower half is overwritten by the factor
    tiles = np.zeros((count, count, _TILE, _TILE))
    for k in range(count):
        rows = matrix[k * _TILE : (k + 1) * _TILE]
        for j in range(k + 1):
            part = rows[:, j * _TILE : (j + 1) * _TILE]
            tiles[j, k, : part.shape[0], : part.shape[1]] = part
    spare = np.arange(n - (count - 1) * _TILE, _TILE)
    tiles[-1, -1, spare, spare] = 1.0
    solution = np.zeros((count, _TILE, right.shape[1]))
    solution.reshape(count * _TILE, -1)[:n] = right
    inverse = np.empty((count, _TILE, _TILE))
    for k in range(count):
        inverse[k] = np.linalg.inv(np.linalg.cholesky(tiles[k, k]))
        solution[k] = inverse[k] @ solution[k]
        below = tiles[k, k + 1 :] @ inverse[k].T
        tiles[k, k + 1 :] = below
        solution[k + 1 :] -= below @ solution[k]
        for i, column in enumerate(tiles[k + 1 :], k + 1):
            column[i:] -= below[i - k - 1 :] @ below[i - k - 1].T
    for k in reversed(range(count)):
        rest = np.swapaxes(tiles[k, k + 1 :], 1, 2) @ solution[k + 1 :]
        solution[k] = inverse[k].T @ (solution[k] - rest.sum(axis=0))
    return solution.reshape(count * _TILE, -1)[:n]


def product(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """A matrix times a vector, in the calling thread."""
    return np.asarray(np.einsum("ij,j->i", matrix, vector))
