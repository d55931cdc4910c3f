"""The step in Warp, on its CPU device (which has one thread), in double precision. It has an array for each quantity, one
kernel for each phase, and loops of constant length over the 3^d nodes; it sums to nodes with `wp.atomic_add` (on the CPU plain sums).

The scheme flip is Pebble's (stress last, gradients of the splines), mls is MLS-MPM with APIC.
"""
import numpy as np
import warp as wp

from peer import serve
from scene import LAMBDA, MU, RHO

wp.config.log_level = wp.LOG_ERROR
wp.config.enable_backward = False
wp.init()

real = wp.float64
ZERO, HALF, ONE = wp.constant(real(0.0)), wp.constant(real(0.5)), wp.constant(real(1.0))
TWO, FOUR = wp.constant(real(2.0)), wp.constant(real(4.0))
NEAR, MID = wp.constant(real(1.5)), wp.constant(real(0.75))
LAM, SHEAR = wp.constant(real(LAMBDA)), wp.constant(real(MU))


@wp.func
def spline(f: real):
    return wp.vec3d(HALF * (NEAR - f) * (NEAR - f), MID - (f - ONE) * (f - ONE), HALF * (f - HALF) * (f - HALF))


@wp.func
def slope(f: real, inv_h: real):
    return wp.vec3d((f - NEAR) * inv_h, -TWO * (f - ONE) * inv_h, (f - HALF) * inv_h)


@wp.func
def reach(f: real):
    return wp.vec3d(-f, ONE - f, TWO - f)


@wp.func
def kirchhoff2(F: wp.mat22d):
    return SHEAR * (F * wp.transpose(F)) + (LAM * wp.log(wp.determinant(F)) - SHEAR) * wp.identity(n=2, dtype=real)


@wp.func
def kirchhoff3(F: wp.mat33d):
    return SHEAR * (F * wp.transpose(F)) + (LAM * wp.log(wp.determinant(F)) - SHEAR) * wp.identity(n=3, dtype=real)


# ---- Nodes: the motion of each from the sums

@wp.kernel
def nodes2(m: wp.array2d(dtype=real), v: wp.array2d(dtype=wp.vec2d), f: wp.array2d(dtype=wp.vec2d), dt: real):
    i, j = wp.tid()
    if m[i, j] > ZERO:
        f[i, j] = f[i, j] / m[i, j]
        v[i, j] = v[i, j] / m[i, j] + dt * f[i, j]


@wp.kernel
def nodes3(m: wp.array3d(dtype=real), v: wp.array3d(dtype=wp.vec3d), f: wp.array3d(dtype=wp.vec3d), dt: real):
    i, j, k = wp.tid()
    if m[i, j, k] > ZERO:
        f[i, j, k] = f[i, j, k] / m[i, j, k]
        v[i, j, k] = v[i, j, k] / m[i, j, k] + dt * f[i, j, k]


@wp.kernel
def nodes2_mls(m: wp.array2d(dtype=real), v: wp.array2d(dtype=wp.vec2d)):
    i, j = wp.tid()
    if m[i, j] > ZERO:
        v[i, j] = v[i, j] / m[i, j]


@wp.kernel
def nodes3_mls(m: wp.array3d(dtype=real), v: wp.array3d(dtype=wp.vec3d)):
    i, j, k = wp.tid()
    if m[i, j, k] > ZERO:
        v[i, j, k] = v[i, j, k] / m[i, j, k]


# ---- flip

@wp.kernel
def p2g2(x: wp.array(dtype=wp.vec2d), v: wp.array(dtype=wp.vec2d), F: wp.array(dtype=wp.mat22d),
         gm: wp.array2d(dtype=real), gv: wp.array2d(dtype=wp.vec2d), gf: wp.array2d(dtype=wp.vec2d),
         inv_h: real, mass: real, volume: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by = int(X[0] - HALF), int(X[1] - HALF)
    fx, fy = X[0] - real(bx), X[1] - real(by)
    wx, wy = spline(fx), spline(fy)
    sx, sy = slope(fx, inv_h), slope(fy, inv_h)
    stress = -volume * kirchhoff2(F[p])
    momentum = mass * v[p]
    for i in range(3):
        for j in range(3):
            weight = wx[i] * wy[j]
            wp.atomic_add(gm, bx + i, by + j, weight * mass)
            wp.atomic_add(gv, bx + i, by + j, weight * momentum)
            wp.atomic_add(gf, bx + i, by + j, stress * wp.vec2d(sx[i] * wy[j], wx[i] * sy[j]))


@wp.kernel
def g2p2(x: wp.array(dtype=wp.vec2d), v: wp.array(dtype=wp.vec2d), F: wp.array(dtype=wp.mat22d),
         gv: wp.array2d(dtype=wp.vec2d), ga: wp.array2d(dtype=wp.vec2d), inv_h: real, dt: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by = int(X[0] - HALF), int(X[1] - HALF)
    fx, fy = X[0] - real(bx), X[1] - real(by)
    wx, wy = spline(fx), spline(fy)
    sx, sy = slope(fx, inv_h), slope(fy, inv_h)
    velocity, acceleration, L = wp.vec2d(), wp.vec2d(), wp.mat22d()
    for i in range(3):
        for j in range(3):
            node = gv[bx + i, by + j]
            velocity += wx[i] * wy[j] * node
            acceleration += wx[i] * wy[j] * ga[bx + i, by + j]
            L += wp.outer(node, wp.vec2d(sx[i] * wy[j], wx[i] * sy[j]))
    v[p] = v[p] + dt * acceleration
    x[p] = x[p] + dt * velocity
    F[p] = F[p] + dt * (L * F[p])


@wp.kernel
def p2g3(x: wp.array(dtype=wp.vec3d), v: wp.array(dtype=wp.vec3d), F: wp.array(dtype=wp.mat33d),
         gm: wp.array3d(dtype=real), gv: wp.array3d(dtype=wp.vec3d), gf: wp.array3d(dtype=wp.vec3d),
         inv_h: real, mass: real, volume: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by, bz = int(X[0] - HALF), int(X[1] - HALF), int(X[2] - HALF)
    fx, fy, fz = X[0] - real(bx), X[1] - real(by), X[2] - real(bz)
    wx, wy, wz = spline(fx), spline(fy), spline(fz)
    sx, sy, sz = slope(fx, inv_h), slope(fy, inv_h), slope(fz, inv_h)
    stress = -volume * kirchhoff3(F[p])
    momentum = mass * v[p]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                weight = wx[i] * wy[j] * wz[k]
                grad = wp.vec3d(sx[i] * wy[j] * wz[k], wx[i] * sy[j] * wz[k], wx[i] * wy[j] * sz[k])
                wp.atomic_add(gm, bx + i, by + j, bz + k, weight * mass)
                wp.atomic_add(gv, bx + i, by + j, bz + k, weight * momentum)
                wp.atomic_add(gf, bx + i, by + j, bz + k, stress * grad)


@wp.kernel
def g2p3(x: wp.array(dtype=wp.vec3d), v: wp.array(dtype=wp.vec3d), F: wp.array(dtype=wp.mat33d),
         gv: wp.array3d(dtype=wp.vec3d), ga: wp.array3d(dtype=wp.vec3d), inv_h: real, dt: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by, bz = int(X[0] - HALF), int(X[1] - HALF), int(X[2] - HALF)
    fx, fy, fz = X[0] - real(bx), X[1] - real(by), X[2] - real(bz)
    wx, wy, wz = spline(fx), spline(fy), spline(fz)
    sx, sy, sz = slope(fx, inv_h), slope(fy, inv_h), slope(fz, inv_h)
    velocity, acceleration, L = wp.vec3d(), wp.vec3d(), wp.mat33d()
    for i in range(3):
        for j in range(3):
            for k in range(3):
                weight = wx[i] * wy[j] * wz[k]
                grad = wp.vec3d(sx[i] * wy[j] * wz[k], wx[i] * sy[j] * wz[k], wx[i] * wy[j] * sz[k])
                node = gv[bx + i, by + j, bz + k]
                velocity += weight * node
                acceleration += weight * ga[bx + i, by + j, bz + k]
                L += wp.outer(node, grad)
    v[p] = v[p] + dt * acceleration
    x[p] = x[p] + dt * velocity
    F[p] = F[p] + dt * (L * F[p])


# ---- mls

@wp.kernel
def p2g2_mls(x: wp.array(dtype=wp.vec2d), v: wp.array(dtype=wp.vec2d), F: wp.array(dtype=wp.mat22d),
             C: wp.array(dtype=wp.mat22d), gm: wp.array2d(dtype=real), gv: wp.array2d(dtype=wp.vec2d),
             inv_h: real, mass: real, volume: real, dt: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by = int(X[0] - HALF), int(X[1] - HALF)
    fx, fy = X[0] - real(bx), X[1] - real(by)
    wx, wy = spline(fx), spline(fy)
    rx, ry = reach(fx), reach(fy)
    F_new = F[p] + dt * (C[p] * F[p])
    F[p] = F_new
    affine = (-dt * volume * FOUR * inv_h) * kirchhoff2(F_new) + (mass / inv_h) * C[p]
    momentum = mass * v[p]
    for i in range(3):
        for j in range(3):
            dpos = wp.vec2d(rx[i], ry[j])
            weight = wx[i] * wy[j]
            wp.atomic_add(gm, bx + i, by + j, weight * mass)
            wp.atomic_add(gv, bx + i, by + j, weight * (momentum + affine * dpos))


@wp.kernel
def g2p2_mls(x: wp.array(dtype=wp.vec2d), v: wp.array(dtype=wp.vec2d), C: wp.array(dtype=wp.mat22d),
             gv: wp.array2d(dtype=wp.vec2d), inv_h: real, dt: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by = int(X[0] - HALF), int(X[1] - HALF)
    fx, fy = X[0] - real(bx), X[1] - real(by)
    wx, wy = spline(fx), spline(fy)
    rx, ry = reach(fx), reach(fy)
    velocity, B = wp.vec2d(), wp.mat22d()
    for i in range(3):
        for j in range(3):
            node = wx[i] * wy[j] * gv[bx + i, by + j]
            velocity += node
            B += wp.outer(node, wp.vec2d(rx[i], ry[j]))
    v[p] = velocity
    C[p] = FOUR * inv_h * B
    x[p] = x[p] + dt * velocity


@wp.kernel
def p2g3_mls(x: wp.array(dtype=wp.vec3d), v: wp.array(dtype=wp.vec3d), F: wp.array(dtype=wp.mat33d),
             C: wp.array(dtype=wp.mat33d), gm: wp.array3d(dtype=real), gv: wp.array3d(dtype=wp.vec3d),
             inv_h: real, mass: real, volume: real, dt: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by, bz = int(X[0] - HALF), int(X[1] - HALF), int(X[2] - HALF)
    fx, fy, fz = X[0] - real(bx), X[1] - real(by), X[2] - real(bz)
    wx, wy, wz = spline(fx), spline(fy), spline(fz)
    rx, ry, rz = reach(fx), reach(fy), reach(fz)
    F_new = F[p] + dt * (C[p] * F[p])
    F[p] = F_new
    affine = (-dt * volume * FOUR * inv_h) * kirchhoff3(F_new) + (mass / inv_h) * C[p]
    momentum = mass * v[p]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                dpos = wp.vec3d(rx[i], ry[j], rz[k])
                weight = wx[i] * wy[j] * wz[k]
                wp.atomic_add(gm, bx + i, by + j, bz + k, weight * mass)
                wp.atomic_add(gv, bx + i, by + j, bz + k, weight * (momentum + affine * dpos))


@wp.kernel
def g2p3_mls(x: wp.array(dtype=wp.vec3d), v: wp.array(dtype=wp.vec3d), C: wp.array(dtype=wp.mat33d),
             gv: wp.array3d(dtype=wp.vec3d), inv_h: real, dt: real):
    p = wp.tid()
    X = x[p] * inv_h
    bx, by, bz = int(X[0] - HALF), int(X[1] - HALF), int(X[2] - HALF)
    fx, fy, fz = X[0] - real(bx), X[1] - real(by), X[2] - real(bz)
    wx, wy, wz = spline(fx), spline(fy), spline(fz)
    rx, ry, rz = reach(fx), reach(fy), reach(fz)
    velocity, B = wp.vec3d(), wp.mat33d()
    for i in range(3):
        for j in range(3):
            for k in range(3):
                node = wx[i] * wy[j] * wz[k] * gv[bx + i, by + j, bz + k]
                velocity += node
                B += wp.outer(node, wp.vec3d(rx[i], ry[j], rz[k]))
    v[p] = velocity
    C[p] = FOUR * inv_h * B
    x[p] = x[p] + dt * velocity


def make(scene, scheme, volume):
    dim, N, shape, mls = scene.dim, scene.particles, (scene.grid + 3,) * scene.dim, scheme == "mls"
    vector, matrix = (wp.vec2d, wp.mat22d) if dim == 2 else (wp.vec3d, wp.mat33d)
    inv_h, mass, dt = float(scene.grid), RHO * volume, scene.dt
    wp.set_device("cpu")
    x, v = wp.zeros(N, dtype=vector), wp.zeros(N, dtype=vector)
    F, C = wp.zeros(N, dtype=matrix), wp.zeros(N if mls else 1, dtype=matrix)
    gm, gv = wp.zeros(shape, dtype=real), wp.zeros(shape, dtype=vector)
    gf = wp.zeros((1,) * dim if mls else shape, dtype=vector)
    p2g, g2p, nodes = {(2, 0): (p2g2, g2p2, nodes2), (3, 0): (p2g3, g2p3, nodes3),
                       (2, 1): (p2g2_mls, g2p2_mls, nodes2_mls), (3, 1): (p2g3_mls, g2p3_mls, nodes3_mls)}[dim, mls]
    unit = np.broadcast_to(np.eye(dim), (N, dim, dim))

    def reset(x0, v0):
        x.assign(x0)
        v.assign(v0)
        F.assign(unit)
        C.zero_()

    def steps(count):
        for _ in range(count):
            gm.zero_()
            gv.zero_()
            if mls:
                wp.launch(p2g, dim=N, inputs=[x, v, F, C, gm, gv, inv_h, mass, volume, dt])
                wp.launch(nodes, dim=shape, inputs=[gm, gv])
                wp.launch(g2p, dim=N, inputs=[x, v, C, gv, inv_h, dt])
            else:
                gf.zero_()
                wp.launch(p2g, dim=N, inputs=[x, v, F, gm, gv, gf, inv_h, mass, volume])
                wp.launch(nodes, dim=shape, inputs=[gm, gv, gf, dt])
                wp.launch(g2p, dim=N, inputs=[x, v, F, gv, gf, inv_h, dt])
        wp.synchronize()

    return reset, steps, v.numpy, lambda: float(gm.numpy().sum())


serve(make)
