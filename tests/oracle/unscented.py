"""The scaled unscented transform, point by point, as section 2.2.4 and van der Merwe have it."""

import math

import numpy as np


def sigma_points(x, P, alpha, beta, kappa):
    """Points [(2n + 1) arrays], weights for means and weights for covariances."""
    n = len(x)
    lam = alpha**2 * (n + kappa) - n
    root = np.linalg.cholesky((n + lam) * P)
    points = [x]
    points += [x + root[:, k] for k in range(n)]
    points += [x - root[:, k] for k in range(n)]
    means = [lam / (n + lam)] + [1 / (2 * (n + lam))] * (2 * n)
    covariances = [lam / (n + lam) + 1 - alpha**2 + beta] + means[1:]
    return points, means, covariances


def transformed(h, x, P, alpha, beta, kappa):
    """Mean, covariance and cross covariance of h(x) for x ~ (x, P)."""
    points, means, covariances = sigma_points(x, P, alpha, beta, kappa)
    images = [np.atleast_1d(h(point)) for point in points]
    size = len(images[0])
    weighted = [w * y for w, y in zip(means, images, strict=True)]
    mean = np.array([math.fsum(y[i] for y in weighted) for i in range(size)])
    P_zz, P_xz = np.zeros((size, size)), np.zeros((len(x), size))
    for weight, point, image in zip(covariances, points, images, strict=True):
        P_zz += weight * np.outer(image - mean, image - mean)
        P_xz += weight * np.outer(point - x, image - mean)
    return mean, P_zz, P_xz
