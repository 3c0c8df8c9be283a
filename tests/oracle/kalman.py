"""Kalman corrections as section 2.2.1 prints them, sums written out."""

import numpy as np


def covariance(weights, a, b):
    """Weighted sum of outer products of deviations a (S, p) and b (S, q), one by one."""
    total = np.zeros((a.shape[1], b.shape[1]))
    for weight, u, v in zip(weights, a, b, strict=True):
        total += weight * np.outer(u, v)
    return total


def dense_correction(P, dX, dY, Wc, nu, R):
    """K = P_xz P_nunu^-1; returns K nu and P - K P_nunu K'."""
    P_xz = covariance(Wc, dX, dY)
    P_nunu = covariance(Wc, dY, dY) + np.diag(R)
    K = P_xz @ np.linalg.inv(P_nunu)
    return K @ nu, P - K @ P_nunu @ K.T


def kalman_correction(x, P, H, z, R):
    """The linear filter of section 2.2.2: posterior mean and covariance."""
    S = H @ P @ H.T + np.diag(R)
    K = P @ H.T @ np.linalg.inv(S)
    return x + K @ (z - H @ x), (np.eye(len(x)) - K @ H) @ P
