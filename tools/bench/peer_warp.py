"""The step in Warp, on its CPU device (which has one thread), in double precision. It has an array for each quantity, one
kernel for each phase, and loops of constant length over the 3^d nodes; it sums to nodes with `wp.atomic_add` (on the CPU plain sums).

The scheme flip is Pebble's (stress last, gradients of the splines), mls is MLS-MPM with APIC. What differs between 2-D and
3-D is written out in the text of the kernels, since kernels with loops over the axes took up to 1.24 times as long.
"""
import os
import re
import runpy
import tempfile

import numpy as np
import warp as wp

from scene import RHO, serve

wp.config.log_level = wp.LOG_ERROR
wp.config.enable_backward = False
wp.init()


def kernels(dim):
    """{name: kernel} of a dimension. EACH NODE stands for loops over the nodes that a particle reaches."""
    axes = [dict(a="xyz"[d], i="ijk"[d], d=d) for d in range(dim)]
    vec, mat, grid = f"wp.vec{dim}d", f"wp.mat{dim}{dim}d", f"wp.array{dim}d"

    def each(form, between=", "):
        return between.join(form.format(**axis) for axis in axes)

    index, node, weight = each("{i}"), each("b{a} + {i}"), each("w{a}[{i}]", " * ")
    grad = ", ".join(" * ".join(f"{'s' if a is b else 'w'}{b['a']}[{b['i']}]" for b in axes) for a in axes)
    fields = f"x: wp.array(dtype={vec}), v: wp.array(dtype={vec}), F: wp.array(dtype={mat}), C: wp.array(dtype={mat})"
    nodes = f"m: {grid}(dtype=real), gv: {grid}(dtype={vec}), gf: {grid}(dtype={vec})"
    find = f"""p = wp.tid()
    X = x[p] * inv_h
    {each("b{a}")} = {each("int(X[{d}] - HALF)")}
    {each("f{a}")} = {each("X[{d}] - real(b{a})")}
    {each("w{a}")} = {each("spline(f{a})")}"""
    text = f"""
import warp as wp
from scene import LAMBDA, MU
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
def kirchhoff(F: {mat}):
    return SHEAR * (F * wp.transpose(F)) + (LAM * wp.log(wp.determinant(F)) - SHEAR) * wp.identity(n={dim}, dtype=real)

@wp.kernel
def p2g_flip({fields}, {nodes}, inv_h: real, mass: real, volume: real, dt: real):
    {find}
    {each("s{a}")} = {each("slope(f{a}, inv_h)")}
    stress = -volume * kirchhoff(F[p])
    momentum = mass * v[p]
    EACH NODE
        weight = {weight}
        wp.atomic_add(m, {node}, weight * mass)
        wp.atomic_add(gv, {node}, weight * momentum)
        wp.atomic_add(gf, {node}, stress * {vec}({grad}))

@wp.kernel
def nodes_flip({nodes}, dt: real):
    {index} = wp.tid()
    if m[{index}] > ZERO:
        gf[{index}] = gf[{index}] / m[{index}]
        gv[{index}] = gv[{index}] / m[{index}] + dt * gf[{index}]

@wp.kernel
def g2p_flip({fields}, {nodes}, inv_h: real, dt: real):
    {find}
    {each("s{a}")} = {each("slope(f{a}, inv_h)")}
    velocity, acceleration, L = {vec}(), {vec}(), {mat}()
    EACH NODE
        weight = {weight}
        node = gv[{node}]
        velocity += weight * node
        acceleration += weight * gf[{node}]
        L += wp.outer(node, {vec}({grad}))
    v[p] = v[p] + dt * acceleration
    x[p] = x[p] + dt * velocity
    F[p] = F[p] + dt * (L * F[p])

@wp.kernel
def p2g_mls({fields}, {nodes}, inv_h: real, mass: real, volume: real, dt: real):
    {find}
    {each("r{a}")} = {each("reach(f{a})")}
    F_new = F[p] + dt * (C[p] * F[p])
    F[p] = F_new
    affine = (-dt * volume * FOUR * inv_h) * kirchhoff(F_new) + (mass / inv_h) * C[p]
    momentum = mass * v[p]
    EACH NODE
        weight = {weight}
        wp.atomic_add(m, {node}, weight * mass)
        wp.atomic_add(gv, {node}, weight * (momentum + affine * {vec}({each("r{a}[{i}]")})))

@wp.kernel
def nodes_mls({nodes}, dt: real):
    {index} = wp.tid()
    if m[{index}] > ZERO:
        gv[{index}] = gv[{index}] / m[{index}]

@wp.kernel
def g2p_mls({fields}, {nodes}, inv_h: real, dt: real):
    {find}
    {each("r{a}")} = {each("reach(f{a})")}
    velocity, B = {vec}(), {mat}()
    EACH NODE
        node = {weight} * gv[{node}]
        velocity += node
        B += wp.outer(node, {vec}({each("r{a}[{i}]")}))
    v[p] = velocity
    C[p] = FOUR * inv_h * B
    x[p] = x[p] + dt * velocity
"""
    loops = "".join(f"    {4 * d * ' '}for {'ijk'[d]} in range(3):\n" for d in range(dim))
    text = re.sub(r"    EACH NODE\n((?: {8}.*\n)+)", lambda m: loops + re.sub("^", 4 * (dim - 1) * " ", m[1].rstrip(), flags=re.M) + "\n", text)
    path = os.path.join(tempfile.mkdtemp(), f"kernels{dim}.py")  # Warp reads the text of its kernels from their file
    with open(path, "w") as f:
        f.write(text)
    return runpy.run_path(path, run_name=f"kernels{dim}")


def make(scene, scheme):
    dim, N, shape, mls = scene.dim, scene.particles, (scene.grid + 3,) * scene.dim, scheme == "mls"
    vector, matrix = (wp.vec2d, wp.mat22d) if dim == 2 else (wp.vec3d, wp.mat33d)
    inv_h, volume, mass, dt = float(scene.grid), scene.volume, RHO * scene.volume, scene.dt
    wp.set_device("cpu")
    fields = [wp.zeros(n, dtype=kind) for n, kind in ((N, vector), (N, vector), (N, matrix), (N if mls else 1, matrix))]
    nodes = [wp.zeros(n, dtype=kind) for n, kind in ((shape, wp.float64), (shape, vector), ((1,) * dim if mls else shape, vector))]
    of = kernels(dim)
    p2g, update, g2p = (of[f"{phase}_{scheme}"] for phase in ("p2g", "nodes", "g2p"))

    def reset(x0, v0):
        for field, start in zip(fields, (x0, v0, np.broadcast_to(np.eye(dim), (N, dim, dim)))):
            field.assign(start)
        fields[3].zero_()

    def steps(count):
        for _ in range(count):
            for sums in nodes[: 2 if mls else 3]:
                sums.zero_()
            wp.launch(p2g, dim=N, inputs=[*fields, *nodes, inv_h, mass, volume, dt])
            wp.launch(update, dim=shape, inputs=[*nodes, dt])
            wp.launch(g2p, dim=N, inputs=[*fields, *nodes, inv_h, dt])
        wp.synchronize()

    return reset, steps, fields[1].numpy, lambda: float(nodes[0].numpy().sum())


serve(make)
