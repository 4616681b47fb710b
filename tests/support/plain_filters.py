"""Filters and smoothers as the textbooks print them, on covariances, and the joint distribution of all samples."""

import numpy as np


def random_model(seed, n=3, q=2, m=1, N=30, changing=False):
    """A stable model with correlated noises, its matrices by name, and samples of which some are lost."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(N if changing else 1, n, n))
    A /= np.abs(np.linalg.eigvals(A)).max(axis=1)[:, None, None] / 0.95
    L = rng.normal(size=(len(A), n, n))
    C, D, B, u = rng.normal(size=(q, n)), rng.normal(size=(q, m)), rng.normal(size=(n, m)), rng.normal(size=(N, m))
    noise = rng.normal(size=(q, q))
    model = {
        "A": A if changing else A[0],
        "C": C,
        "Q": L @ np.swapaxes(L, 1, 2) if changing else L[0] @ L[0].T,
        "R": noise @ noise.T + 0.1 * np.eye(q),
        "x0": rng.normal(size=n),
        "P0": np.eye(n) + 0.5,
        "B": B,
        "D": D,
        "u": u,
    }
    y = rng.normal(size=(N, q))
    y[rng.random((N, q)) < 0.2] = np.nan
    y[5] = np.nan
    return model, y


def joint_distribution(model, y):
    """Mean and covariance of all states, and the log-likelihood, means and covariances given samples up to each k.

    All states are one normal vector, whose covariance is written down and conditioned at once.
    """
    N, n = len(y), len(model["x0"])
    A, Q = (np.broadcast_to(model[name], (N, n, n)) for name in "AQ")
    mean, S = np.zeros((N, n)), np.zeros((N, n, N, n))
    mean[0], S[0, :, 0] = model["x0"], model["P0"]
    for k in range(N - 1):
        mean[k + 1] = A[k] @ mean[k] + model["B"] @ model["u"][k]
        S[k + 1] = np.einsum("ij,jlm->ilm", A[k], S[k])
        S[:, :, k + 1] = np.einsum("lmj,ij->lmi", S[:, :, k], A[k])
        S[k + 1, :, k + 1] = A[k] @ S[k, :, k] @ A[k].T + Q[k]
    return mean.ravel(), S.reshape(N * n, N * n)


def given_samples(model, y, up_to):
    """Mean (N, n) and covariance (N, n, n) of each state given the samples before `up_to`, and their log density."""
    (N, q), n = y.shape, len(model["x0"])
    mean, S = joint_distribution(model, y)
    rows = [(k, i) for k in range(up_to) for i in range(q) if np.isfinite(y[k, i])]
    H, e, R = np.zeros((len(rows), N * n)), np.zeros(len(rows)), np.zeros((len(rows), len(rows)))
    for row, (k, i) in enumerate(rows):
        H[row, k * n : (k + 1) * n] = model["C"][i]
        e[row] = y[k, i] - model["C"][i] @ mean[k * n : (k + 1) * n] - model["D"][i] @ model["u"][k]
        for other, (l, j) in enumerate(rows):
            R[row, other] = model["R"][i, j] if l == k else 0.0
    V = H @ S @ H.T + R
    K = np.linalg.solve(V, H @ S).T
    x, P = mean + K @ e, S - K @ H @ S
    log_density = -0.5 * (len(e) * np.log(2 * np.pi) + np.linalg.slogdet(V)[1] + e @ np.linalg.solve(V, e))
    blocks = P.reshape(N, n, N, n)[np.arange(N), :, np.arange(N)]
    return x.reshape(N, n), blocks, log_density


def extended(f, h, F, H, Q, R, x, P, y):
    """The extended filter and its Rauch-Tung-Striebel smoother: Sarkka (2013), algorithms 5.4 and 9.1."""
    before, after, jacobians = [], [], []
    for k in range(len(y)):
        before.append((x, P))
        S, C = H(x) @ P @ H(x).T + R, H(x)
        K = P @ C.T @ np.linalg.inv(S)
        x, P = x + K @ (y[k] - h(x)), P - K @ S @ K.T
        after.append((x, P))
        jacobians.append(F(x))
        x, P = f(x), F(x) @ P @ F(x).T + Q
    smooth = [after[-1]]
    for k in range(len(y) - 2, -1, -1):
        (x, P), (xp, Pp) = after[k], before[k + 1]
        G = P @ jacobians[k].T @ np.linalg.inv(Pp)
        smooth.insert(0, (x + G @ (smooth[0][0] - xp), P + G @ (smooth[0][1] - Pp) @ G.T))
    return before, after, smooth


def unscented(f, h, Q, R, x, P, y, alpha, beta, kappa):
    """The unscented filter and its smoother: Sarkka (2013), algorithms 5.14 and 10.3."""
    n = len(x)
    c = alpha**2 * (n + kappa)
    Wm = np.array([1 - n / c] + 2 * n * [0.5 / c])
    Wc = Wm + np.array([1 - alpha**2 + beta] + 2 * n * [0])

    def transform(function, x, P):
        L = np.linalg.cholesky(c * P)
        X = np.column_stack([x, x[:, None] + L, x[:, None] - L])
        Y = np.column_stack([function(point) for point in X.T])
        mean = Y @ Wm
        return mean, (Y - mean[:, None]) * Wc @ (Y - mean[:, None]).T, (X - x[:, None]) * Wc @ (Y - mean[:, None]).T

    before, after, across = [], [], []
    for k in range(len(y)):
        before.append((x, P))
        mean, S, cross = transform(h, x, P)
        K = cross @ np.linalg.inv(S + R)
        x, P = x + K @ (y[k] - mean), P - K @ (S + R) @ K.T
        after.append((x, P))
        x, moved, cross = transform(f, x, P)
        across.append(cross)
        P = moved + Q
    smooth = [after[-1]]
    for k in range(len(y) - 2, -1, -1):
        (x, P), (xp, Pp) = after[k], before[k + 1]
        G = across[k] @ np.linalg.inv(Pp)
        smooth.insert(0, (x + G @ (smooth[0][0] - xp), P + G @ (smooth[0][1] - Pp) @ G.T))
    return before, after, smooth
