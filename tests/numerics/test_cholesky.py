import numpy as np
import pytest

from numerics.cholesky import inverse_positive, solve_positive


@pytest.mark.parametrize("size", [1, 6, 8])
def test_it_solves_damped_systems_from_the_lower_triangle(size: int) -> None:
    random = np.random.default_rng(size)
    half = random.normal(size=(size + 3, size))
    matrix, vector = half.T @ half, random.normal(size=size)
    expected = np.linalg.solve(matrix + np.diag(0.01 * np.diag(matrix) + 0.1), vector)
    np.testing.assert_allclose(solve_positive(np.tril(matrix), vector, 0.01, 0.1), expected, rtol=1e-9)


@pytest.mark.parametrize("matrix", [np.full((6, 6), np.nan), np.zeros((6, 6)), -np.eye(6)])
def test_what_is_not_positive_definite_has_no_solution(matrix: np.ndarray) -> None:
    assert (solve_positive(matrix, np.ones(6), 0.0, 0.0) == 0).all()


@pytest.mark.parametrize("size", [1, 6, 9])
def test_it_inverts_from_the_lower_triangle(size: int) -> None:
    random = np.random.default_rng(size)
    half = random.normal(size=(size + 3, size)) * 10.0 ** np.linspace(-3, 3, size)
    matrix = half.T @ half
    found = inverse_positive(np.tril(matrix))
    np.testing.assert_allclose(found @ matrix, np.eye(size), atol=1e-7)
    np.testing.assert_array_equal(found, found.T)


@pytest.mark.parametrize("matrix", [np.full((6, 6), np.nan), np.zeros((6, 6)), -np.eye(6)])
def test_what_is_not_positive_definite_has_no_inverse(matrix: np.ndarray) -> None:
    assert np.isnan(inverse_positive(matrix)).all()
