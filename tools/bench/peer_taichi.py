"""The step in Taichi, on one core, in double precision, written as its examples mpm128 and mpm3d are. It has a field for each
quantity, one kernel for each phase, and unrolled loops over the 3^d nodes; it sums to nodes with `+=`.

The scheme flip is Pebble's (stress last, gradients of the splines), mls is MLS-MPM with APIC, as in the examples.
"""
import taichi as ti

from peer import serve
from scene import LAMBDA, MU, RHO

ti.init(arch=ti.cpu, cpu_max_num_threads=1, default_fp=ti.f64, log_level=ti.ERROR, offline_cache=False)


def make(scene, scheme, volume):
    dim, n, N = scene.dim, scene.grid + 3, scene.particles
    dt, inv_h, h, mass = scene.dt, float(scene.grid), scene.h, RHO * volume
    x, v = ti.Vector.field(dim, ti.f64, N), ti.Vector.field(dim, ti.f64, N)
    F, C = ti.Matrix.field(dim, dim, ti.f64, N), ti.Matrix.field(dim, dim, ti.f64, N)
    shape = (n,) * dim
    grid_m, grid_v = ti.field(ti.f64, shape), ti.Vector.field(dim, ti.f64, shape)
    grid_f = ti.Vector.field(dim, ti.f64, shape if scheme == "flip" else (1,) * dim)

    @ti.kernel
    def start():
        for p in x:
            F[p] = ti.Matrix.identity(ti.f64, dim)
            C[p] = ti.Matrix.zero(ti.f64, dim, dim)

    @ti.func
    def spline(fx):
        return [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2]

    @ti.func
    def slope(fx):
        return [(fx - 1.5) * inv_h, -2 * (fx - 1) * inv_h, (fx - 0.5) * inv_h]

    @ti.func
    def kirchhoff(f):
        return MU * (f @ f.transpose()) + (LAMBDA * ti.log(f.determinant()) - MU) * ti.Matrix.identity(ti.f64, dim)

    @ti.kernel
    def p2g_flip():
        for I in ti.grouped(grid_m):
            grid_m[I] = 0
            grid_v[I] = ti.Vector.zero(ti.f64, dim)
            grid_f[I] = ti.Vector.zero(ti.f64, dim)
        for p in x:
            base = ti.cast(x[p] * inv_h - 0.5, ti.i32)
            fx = x[p] * inv_h - ti.cast(base, ti.f64)
            w, g = spline(fx), slope(fx)
            stress = -volume * kirchhoff(F[p])
            momentum = mass * v[p]
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * dim)))):
                weight, grad = 1.0, ti.Vector.one(ti.f64, dim)
                for d in ti.static(range(dim)):
                    weight *= w[offset[d]][d]
                    for e in ti.static(range(dim)):
                        grad[d] *= (g if d == e else w)[offset[e]][e]
                grid_m[base + offset] += weight * mass
                grid_v[base + offset] += weight * momentum
                grid_f[base + offset] += stress @ grad

    @ti.kernel
    def nodes_flip():
        for I in ti.grouped(grid_m):
            if grid_m[I] > 0:
                grid_f[I] /= grid_m[I]
                grid_v[I] = grid_v[I] / grid_m[I] + dt * grid_f[I]

    @ti.kernel
    def g2p_flip():
        for p in x:
            base = ti.cast(x[p] * inv_h - 0.5, ti.i32)
            fx = x[p] * inv_h - ti.cast(base, ti.f64)
            w, g = spline(fx), slope(fx)
            velocity, acceleration = ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim)
            L = ti.Matrix.zero(ti.f64, dim, dim)
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * dim)))):
                weight, grad = 1.0, ti.Vector.one(ti.f64, dim)
                for d in ti.static(range(dim)):
                    weight *= w[offset[d]][d]
                    for e in ti.static(range(dim)):
                        grad[d] *= (g if d == e else w)[offset[e]][e]
                node = grid_v[base + offset]
                velocity += weight * node
                acceleration += weight * grid_f[base + offset]
                L += node.outer_product(grad)
            v[p] += dt * acceleration
            x[p] += dt * velocity
            F[p] += dt * L @ F[p]

    @ti.kernel
    def p2g_mls():
        for I in ti.grouped(grid_m):
            grid_m[I] = 0
            grid_v[I] = ti.Vector.zero(ti.f64, dim)
        for p in x:
            base = ti.cast(x[p] * inv_h - 0.5, ti.i32)
            fx = x[p] * inv_h - ti.cast(base, ti.f64)
            w = spline(fx)
            F[p] = (ti.Matrix.identity(ti.f64, dim) + dt * C[p]) @ F[p]
            affine = -dt * volume * 4 * inv_h * inv_h * kirchhoff(F[p]) + mass * C[p]
            momentum = mass * v[p]
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * dim)))):
                dpos = (ti.cast(offset, ti.f64) - fx) * h
                weight = 1.0
                for d in ti.static(range(dim)):
                    weight *= w[offset[d]][d]
                grid_v[base + offset] += weight * (momentum + affine @ dpos)
                grid_m[base + offset] += weight * mass

    @ti.kernel
    def nodes_mls():
        for I in ti.grouped(grid_m):
            if grid_m[I] > 0:
                grid_v[I] = grid_v[I] / grid_m[I]

    @ti.kernel
    def g2p_mls():
        for p in x:
            base = ti.cast(x[p] * inv_h - 0.5, ti.i32)
            fx = x[p] * inv_h - ti.cast(base, ti.f64)
            w = spline(fx)
            velocity = ti.Vector.zero(ti.f64, dim)
            new_C = ti.Matrix.zero(ti.f64, dim, dim)
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * dim)))):
                dpos = ti.cast(offset, ti.f64) - fx
                weight = 1.0
                for d in ti.static(range(dim)):
                    weight *= w[offset[d]][d]
                node = grid_v[base + offset]
                velocity += weight * node
                new_C += 4 * inv_h * weight * node.outer_product(dpos)
            v[p], C[p] = velocity, new_C
            x[p] += dt * velocity

    phases = {"flip": (p2g_flip, nodes_flip, g2p_flip), "mls": (p2g_mls, nodes_mls, g2p_mls)}[scheme]

    def reset(x0, v0):
        x.from_numpy(x0)
        v.from_numpy(v0)
        start()

    def steps(count):
        for _ in range(count):
            for phase in phases:
                phase()
        ti.sync()

    return reset, steps, v.to_numpy, lambda: float(grid_m.to_numpy().sum())


serve(make)
