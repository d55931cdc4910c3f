"""Bodies of revolution beside exact solutions, on grids of which each is finer than the last.

usage: verify_axisymmetric.py PEBBLE SOURCE MPIEXEC PART

PART: modes lame drawn limit water taylor meets. Every row says what was measured, what is exact, and what is allowed.
"""
import itertools
import math

import numpy as np

import check
from setups_axisymmetric import MODES, TOTAL, breathing, contact_time, drawn, impact, lame, round_scene, run_scene

WAYS = {"default": {}, "gimp stretch": {"method_basis": "gimp", "method_update": "musl", "method_transfer": "flip", "method_gimp_update": "stretch"},
        "bspline2 apic": {"method_basis": "bspline2", "method_update": "usl", "method_transfer": "apic"},
        "linear xpic": {"method_basis": "linear", "method_update": "musl", "method_transfer": "xpic"}}


def row(good, name, measured, exact, allowed):
    check.that(good, f"{name:<52} {measured:<44} exact {exact:<24} allowed {allowed}")


def modes():
    """Frequencies of the lowest breathing modes of free bodies; J0 and j1 in solid mechanics (docs/method.md)."""
    for (shape, nu), k in MODES.items():
        for name, way in {**WAYS, "solid": TOTAL}.items():
            offs, most = [], 0.0005 if way is TOTAL else 0.01
            for n in (16, 32):
                off, energy, rest = breathing(shape, nu, n, **way)
                offs.append(abs(off))
            row(offs[1] < most and (offs[1] < offs[0] or offs[1] < 1e-3), f"breathing {shape}, nu {nu}, {name}, 16 and 32 cells",
                f"k R {k * (1 + off):.5f} off by {100 * offs[0]:.3f}, {100 * offs[1]:.3f} % energy {energy:.4f}", f"{k}", f"{100 * most:g} %, falling or 0.1 %")


def thick():
    """Tube and sphere of radii 1 and 2 under an inner pressure of E/1000 (Lame). It acts on the deformed surface, which is 0.2 %
    larger; the staircase of the sphere's surface is what is wrong there."""
    for shape, allowed in (("tube", (0.008, 0.004, 0.004)), ("sphere", (0.035, 0.028, 0.017))):
        for name, way in [*list(WAYS.items())[:3], ("solid", TOTAL)]:
            rows = [lame(shape, n, **way) for n in (8, 16, 32)]
            for at in (0, 1):
                found, exact = [r[at][1] for r in rows], rows[0][at][2]
                offs = [abs(value / exact - 1) for value in found]
                row(all(off < most for off, most in zip(offs, allowed)), f"{shape}, u({rows[0][at][0]}), {name}, 8, 16, 32 cells",
                    " ".join(f"{value:.4e}" for value in found), f"{exact:.4e}", " ".join(f"{100 * most:g} %" for most in allowed))


def inwards():
    """A ball, and one with a hole, that a force draws to the centre, with whole places of the lattice and with cut ones, the default."""
    for inner in (0, 1):
        for name, way, allowed in (("default, rim whole", {"method_rim": "whole"}, (0.015, 0.008)), ("default", {}, (8e-4, 4e-4)),
                                   ("solid, rim whole", {**TOTAL, "method_rim": "whole"}, (0.02, 0.013)), ("solid", TOTAL, (4.5e-3, 2.7e-3)),
                                   ("solid, 3 x 3 particles", {**TOTAL, "body_b_ppc": "3,3"}, (2.5e-3, 1e-3))):
            errors = [drawn(inner, n, **way) for n in (8, 16)]
            row(all(error < most for error, most in zip(errors, allowed)) and errors[1] < errors[0],
                f"ball{' with a hole' if inner else ''} drawn inwards, {name}, 8, 16 cells", " ".join(f"{100 * error:.4f}" for error in errors) + " % rms", "0",
                " ".join(f"{100 * most:g} %" for most in allowed) + ", falling")


def limit():
    """The largest pressure that a thick tube or sphere of metal bears: 2/sqrt(3) ln 2 and 2 ln 2 of its yield stress. Below it
    the body comes to rest, above it flows on."""
    limits = {"tube": 2 / math.sqrt(3) * math.log(2), "sphere": 2 * math.log(2)}
    for (shape, exact), (name, way) in itertools.product(limits.items(), (("default", {}), ("solid", TOTAL))):
        for share, rests in ((0.94, True), (1.06, False)):
            p, moved = share * exact, []
            where = "*(X^2+Y^2<2.25)" if shape == "sphere" else ""
            for end in (3, 4):
                found = lame(shape, 8, material_m_model="vonmises", material_m_yield=1, load_p_value=f'"{p}*min(t,1){where}"', time_end=end, damping_time=0.1, **way)
                moved.append(found[0][1])
            rate = (moved[1] - moved[0]) / moved[1]
            row((abs(rate) < 0.02) == rests, f"{shape} of metal, {name}, pressure {share} of the limit", f"u(1) {moved[0]:.3e} at 3 s, {moved[1]:.3e} at 4 s",
                "at rest" if rests else "flows", "2 % of growth")


def water():
    """The pressure of water in a round tank, 1 m deep and 1 m in radius."""
    for name, way in list(WAYS.items())[:3]:
        rms, axis, foot = [], [], []
        for n in (8, 16):
            run_scene("water", round_scene(grid_upper="1,1.5", grid_h=f"{1 / n},{1 / n}", bc_xmax_type="slip", bc_ymin_type="slip", material_m_model="fluid",
                                           material_m_E=None, material_m_nu=None, material_m_K=2e6, acceleration='"0,-9.81*min(t/0.5,1)"', time_end=3,
                                           damping_time=0.1, history_walls="ymin", **{k: v for k, v in way.items() if k != "method_gimp_update"}))
            found = check.particles("water.h5", -1, ("x", "stress", "volume"))
            x, V, off = found["x"], found["volume"], -found["stress"].reshape(-1, 9)[:, 8] / 9810 - (1 - found["x"][:, 1])
            rms.append(math.sqrt(np.average(off**2, weights=V)))
            axis.append(math.sqrt(np.average(off**2, weights=V * (x[:, 0] < 2 / n))))
            rows = check.history("water.csv")
            foot.append(rows["reaction_ymin_y"][-1] / (9.81 * rows["mass"][0]))
        row(rms[1] < 0.6 * rms[0] and rms[1] < 0.016 and axis[1] < 1.2 * rms[1] and abs(foot[1] - 1) < 1e-4, f"water in a round tank, {name}, 8 and 16 cells",
            f"rms {rms[0]:.4f} {rms[1]:.4f} at the axis {axis[0]:.4f} {axis[1]:.4f} force {foot[1]:.5f}", "0, 0, 1", "0.016, falling, 1e-4")


def taylor():
    """The Taylor bar of options/taylor_axi.opts beside finite elements (docs/trust.md): length and radius of the foot, mm."""
    for name, way, cells in (("default", (), (4, 8, 16)), ("solid", ("-method_preset", "solid"), (4, 8))):
        lengths, feet = [], []
        for n in cells:
            check.must("-options_file", check.scene("taylor_axi"), "-grid_cells", f"{3 * n},{10 * n + n // 2}", "-output_dir", ".", *way, timeout=1200)
            x = check.particles("taylor_axi.h5", -1, ("x",))["x"] * 1000
            lengths.append(x[:, 1].max() + 0.8 / n)
            feet.append(x[:, 0].max() + 0.8 / n)
        on = f"{name}, {', '.join(map(str, cells))} cells"
        row(abs(lengths[-1] - 21.5) < 0.1 and max(lengths) - min(lengths) < 0.1, f"Taylor bar, length, {on}", " ".join(f"{v:.2f}" for v in lengths), "21.4 to 21.7 mm", "0.1 mm of 21.5")
        row(abs(feet[-1] - 7.1) < 0.15, f"Taylor bar, radius of the foot, {on}", " ".join(f"{v:.2f}" for v in feet), "7.0 to 7.2 mm", "0.15 mm of 7.1")


def meets():
    """An elastic ball on a rigid plate (Hertz), and a rigid round plate, smooth or rough, that is pushed into clay by 1 % of its width:
    pi R^2 c times 5.69 and 6.05 (Eason and Shield 1960)."""
    times, forces, ns = [], [], (8, 16, 32)
    for n in ns:
        rows, time, force = impact(n)
        times.append(contact_time(rows, rows["reaction_r_y"]) / time)
        forces.append(rows["reaction_r_y"].max() / force)
    row(abs(times[-1] - 1) < 0.1 and abs(forces[-1] - 1) < 0.1, f"ball on a rigid plate, {', '.join(map(str, ns))} cells, time",
        f"{' '.join(f'{v:.3f}' for v in times)} force {' '.join(f'{v:.3f}' for v in forces)} of Hertz", "1", "10 %")
    for rub, exact in ((0, 5.69), (1, 6.05)):
        found = []
        for n in (4, 8):
            run_scene("footing", round_scene(grid_lower="0,-4", grid_upper="4,1", grid_h=f"{1 / n},{1 / n}", material_m_model="vonmises", material_m_yield=1732, material_m_nu=0.49,
                                             method_locking="fbar", bodies="b,r", body_b_lower="0,-4", body_b_upper="4,0", body_r_shape="box", body_r_lower="0,0", body_r_upper="1,1",
                                             body_r_rigid="moving", body_r_velocity='"0,-0.02*min(t/0.3,1)"', body_r_mu=rub, bc_ymin_type="fixed", bc_xmax_type="slip",
                                             history_bodies="r", time_end=1.15))
            rows = check.history("footing.csv")
            found.append(-rows["reaction_r_y"][-5:].mean() / (1000 * math.pi))
        row(abs(found[-1] / exact - 1) < 0.1, f"{'rough' if rub else 'smooth'} round footing on clay, 8 and 16 cells wide", " ".join(f"{v:.3f}" for v in found) + " pi R^2 c", f"{exact}", "10 %")


PARTS = {"meets": meets, "modes": modes, "lame": thick, "drawn": inwards, "limit": limit, "water": water, "taylor": taylor}

if __name__ == "__main__":
    [part] = check.arguments(__doc__, 1)
    PARTS[part]()
    check.end()
