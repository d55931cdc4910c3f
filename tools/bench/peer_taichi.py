"""The step in Taichi, on one core, in double precision, written as its examples mpm128 and mpm3d are. It has a field for each
quantity, one kernel for each phase, and unrolled loops over the 3^d nodes; it sums to nodes with `+=`.

The scheme flip is Pebble's (stress last, gradients of the splines), mls is MLS-MPM with APIC, as in the examples; ti.static
chooses between them when a kernel is compiled.
"""
import taichi as ti

from scene import LAMBDA, MU, RHO, serve

ti.init(arch=ti.cpu, cpu_max_num_threads=1, default_fp=ti.f64, log_level=ti.ERROR, offline_cache=False)


def make(scene, scheme):
    dim, n, N, flip = scene.dim, scene.grid + 3, scene.particles, scheme == "flip"
    dt, inv_h, h, volume, mass = scene.dt, float(scene.grid), scene.h, scene.volume, RHO * scene.volume
    x, v = ti.Vector.field(dim, ti.f64, N), ti.Vector.field(dim, ti.f64, N)
    F, C = ti.Matrix.field(dim, dim, ti.f64, N), ti.Matrix.field(dim, dim, ti.f64, N)
    shape = (n,) * dim
    grid_m, grid_v = ti.field(ti.f64, shape), ti.Vector.field(dim, ti.f64, shape)
    grid_f = ti.Vector.field(dim, ti.f64, shape if flip else (1,) * dim)

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
    def product(w: ti.template(), offset: ti.template()):
        weight = 1.0
        for d in ti.static(range(dim)):
            weight *= w[offset[d]][d]
        return weight

    @ti.func
    def gradient(w: ti.template(), g: ti.template(), offset: ti.template()):
        grad = ti.Vector.one(ti.f64, dim)
        for d, e in ti.static(ti.ndrange(dim, dim)):
            grad[d] *= (g if d == e else w)[offset[e]][e]
        return grad

    @ti.func
    def kirchhoff(f):
        return MU * (f @ f.transpose()) + (LAMBDA * ti.log(f.determinant()) - MU) * ti.Matrix.identity(ti.f64, dim)

    @ti.kernel
    def p2g():
        for I in ti.grouped(grid_m):
            grid_m[I] = 0
            grid_v[I] = ti.Vector.zero(ti.f64, dim)
            if ti.static(flip):
                grid_f[I] = ti.Vector.zero(ti.f64, dim)
        for p in x:
            base = ti.cast(x[p] * inv_h - 0.5, ti.i32)
            fx = x[p] * inv_h - ti.cast(base, ti.f64)
            w, g, momentum, factor = spline(fx), slope(fx), mass * v[p], -volume
            if ti.static(not flip):
                F[p] = (ti.Matrix.identity(ti.f64, dim) + dt * C[p]) @ F[p]
                factor *= dt * 4 * inv_h * inv_h
            flux = factor * kirchhoff(F[p])
            if ti.static(not flip):
                flux += mass * C[p]
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * dim)))):
                weight = product(w, offset)
                grid_m[base + offset] += weight * mass
                if ti.static(flip):
                    grid_v[base + offset] += weight * momentum
                    grid_f[base + offset] += flux @ gradient(w, g, offset)
                else:
                    grid_v[base + offset] += weight * (momentum + flux @ ((ti.cast(offset, ti.f64) - fx) * h))

    @ti.kernel
    def nodes():
        for I in ti.grouped(grid_m):
            if grid_m[I] > 0:
                grid_v[I] /= grid_m[I]
                if ti.static(flip):
                    grid_f[I] /= grid_m[I]
                    grid_v[I] += dt * grid_f[I]

    @ti.kernel
    def g2p():
        for p in x:
            base = ti.cast(x[p] * inv_h - 0.5, ti.i32)
            fx = x[p] * inv_h - ti.cast(base, ti.f64)
            w, g = spline(fx), slope(fx)
            velocity, acceleration = ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim)
            L = ti.Matrix.zero(ti.f64, dim, dim)
            for offset in ti.static(ti.grouped(ti.ndrange(*((3,) * dim)))):
                weight, node = product(w, offset), grid_v[base + offset]
                velocity += weight * node
                if ti.static(flip):
                    acceleration += weight * grid_f[base + offset]
                    L += node.outer_product(gradient(w, g, offset))
                else:
                    L += 4 * inv_h * weight * node.outer_product(ti.cast(offset, ti.f64) - fx)
            x[p] += dt * velocity
            if ti.static(flip):
                v[p] += dt * acceleration
                F[p] += dt * L @ F[p]
            else:
                v[p], C[p] = velocity, L

    def reset(x0, v0):
        x.from_numpy(x0)
        v.from_numpy(v0)
        start()

    def steps(count):
        for _ in range(count):
            for phase in (p2g, nodes, g2p):
                phase()
        ti.sync()

    return reset, steps, v.to_numpy, lambda: float(grid_m.to_numpy().sum())


serve(make)
