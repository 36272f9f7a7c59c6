r"""Contact forces between nodes: near linear interpolation, and consistent with the motion.

At nodes the forces are unknowns of the problem and the equations of the root hold exactly. Between
nodes the motion is that of the spline, and requires a wrench :math:`w` at the root. Linearly
interpolated forces :math:`f` nearly provide it; the change that provides all of it,

.. math:: \delta = W A^\top (A W A^\top)^{-1} (w - A f),

is the least one when sites that carry more may change more (:math:`A` maps forces to their wrench
about the pelvis, :math:`W` holds squared loads). Where a force would then pull or leave the
friction pyramid, a quadratic program finds the forces instead; where the motion requires what the
ground cannot provide, a remainder is left, which the checker sees.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.batched import BatchedFunction
from plantigrade.constants import FRICTION
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.dynamics import asked_by

States = Float[Array, "n nv"]

_MIN_LOAD = 0.01  # [body weights] minimum load of a participating site
_WRENCH_WEIGHT = 1e8  # [1] weight of a missing wrench relative to a change of forces


def explaining(
    body: ContactBody,
    q: States,
    v: States,
    a: States,
    force: Float[Array, "n n_sites 3"],
    standing: Bool[Array, "n n_sites"],
    friction: float = FRICTION,
    times: Float[Array, " n"] | None = None,
) -> Float[Array, "n n_sites 3"]:
    """Return forces that provide the wrench a motion requires, as far as the ground can.

    Args:
        force: Forces to stay near, world [N].
        standing: Which sites are on the ground.
        times: When, where something acts on the body from outside [s].
    """
    if not body.sites:
        return force
    n, k = force.shape[:2]
    required, A = _wrenches(body, q, v, a, times)
    # in the axes of the surfaces
    A = np.einsum("nikx,kxy->niky", A.reshape(n, 6, k, 3), body.surfaces).reshape(n, 6, 3 * k)
    f = np.einsum("nkx,kxy->nky", force, body.surfaces).reshape(n, 3 * k) / body.weight
    load = np.where(standing, np.maximum(f.reshape(n, k, 3)[..., 2], 0.0), 0.0)
    share = np.repeat((load + _MIN_LOAD * (load > _MIN_LOAD / 10)) ** 2, 3, axis=1)
    missing = required - np.einsum("nij,nj->ni", A, f)
    weighed = A * share[:, None, :]
    normal = np.matmul(weighed, A.transpose(0, 2, 1)) + 1e-12 * np.eye(6)
    change = np.linalg.solve(normal, missing[..., None])
    out = f + np.matmul(weighed.transpose(0, 2, 1), change)[..., 0]
    left = np.abs(required - np.einsum("nij,nj->ni", A, out)).max(axis=1)
    side = body.friction(friction) / np.sqrt(2.0)
    forces = out.reshape(n, k, 3)
    beyond = (np.abs(forces[..., :2]).max(axis=2) > side * forces[..., 2] + 1e-9).any(axis=1)
    for i in np.flatnonzero((beyond | (left > 1e-6)) & standing.any(axis=1)):
        out[i] = _within(A[i], required[i], f[i], standing[i], side)
    return np.einsum("kxy,nky->nkx", body.surfaces, out.reshape(n, k, 3)) * body.weight


def remainder(
    body: ContactBody,
    q: States,
    v: States,
    a: States,
    force: Float[Array, "n n_sites 3"],
    times: Float[Array, " n"] | None = None,
) -> Float[Array, " n"]:
    """Return the wrench at the root that forces do not account for.

    Returns:
        The larger of force [body weights] and moment about the pelvis [body weight · m].
    """
    required, A = _wrenches(body, q, v, a, times)
    f = force.reshape(len(force), -1) / body.weight
    left = required - np.einsum("nij,nj->ni", A, f)
    return np.maximum(np.linalg.norm(left[:, :3], axis=1), np.linalg.norm(left[:, 3:], axis=1))


def _wrenches(
    body: ContactBody, q: Array, v: Array, a: Array, times: Array | None
) -> tuple[Array, Array]:
    """Return the wrench a motion requires [body weights], and the matrix from forces to it."""
    symbolic, sites = body.symbolic, list(body.sites)
    places = body.cache.get("site positions", lambda: BatchedFunction(symbolic.positions(sites)))
    frames = body.cache.get("frames", lambda: BatchedFunction(symbolic.frames()))
    n, k = len(q), len(body.sites)
    required, _ = asked_by(body, q, v, a, np.zeros((n, 3 * k)), times)
    place = places(q)[0].reshape(n, k, 3)
    arm = place - frames(q)[0].reshape(n, -1, 3)[:, :1]
    A = np.zeros((n, 6, k, 3))
    A[:, :3] = np.eye(3)[None, :, None, :]
    x, y, z = arm[..., 0], arm[..., 1], arm[..., 2]
    A[:, 3, :, 1], A[:, 3, :, 2] = -z, y
    A[:, 4, :, 0], A[:, 4, :, 2] = z, -x
    A[:, 5, :, 0], A[:, 5, :, 1] = -y, x
    return required, A.reshape(n, 6, 3 * k)


def _within(A: Array, required: Array, f: Array, standing: Array, side: Array) -> Array:
    """Return forces near ``f`` that keep the friction pyramid and give as much as they can."""
    import daqp

    places = np.flatnonzero(standing)
    at = (3 * places[:, None] + np.arange(3)).ravel()
    m = len(places)
    load = np.repeat(np.maximum(f[at[2::3]], 0.0) + _MIN_LOAD, 3)
    G = A[:, at]
    H = _WRENCH_WEIGHT * G.T @ G + np.diag(1.0 / load**2)
    g = -_WRENCH_WEIGHT * G.T @ required - f[at] / load**2
    C = np.kron(np.eye(m), [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    C -= np.repeat(np.kron(np.diag(side[places]), [0.0, 0.0, 1.0]), 4, axis=0)
    upper, lower = np.zeros(4 * m), np.full(4 * m, -1e30)
    x, _, flag, _ = daqp.solve(H, g, C, upper, lower, np.zeros(4 * m, dtype=np.int32))
    out = np.zeros(len(f))
    out[at] = x if flag > 0 else f[at]
    return out
