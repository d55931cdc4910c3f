"""Transfers with an affine velocity: what walls and free edges do to apic, and what afmpm adds to it.

usage: test_affine.py PEBBLE SOURCE MPIEXEC
"""
import re

import h5py
import numpy as np

import check

CELLS, MODE, STEPS, CFL = 64, 4, 800, 0.4  # of the bar: kh = pi/16
INERTIA = {"bspline2": 84, "bspline3": 44}  # apic damps a wave by (kh)^4/84 or /44 of its amplitude a step


def damping(name, face, *method):
    """Share of its amplitude that a standing wave in a bar of 64 cells loses in a step: the mean energy over a period, at
    the end against the start."""
    dt = CFL / CELLS
    check.must("-dim", "1", "-grid_lower", "0", "-grid_upper", "1", "-grid_cells", str(CELLS), "-bc_xmin_type", face, "-bc_xmax_type", face,
               "-materials", "m", "-material_m_model", "elastic", "-material_m_rho", "1", "-material_m_E", "1", "-material_m_nu", "0",
               "-bodies", "b", "-body_b_shape", "box", "-body_b_lower", "0", "-body_b_upper", "1", "-body_b_material", "m",
               "-body_b_velocity", f"1e-6*sin({MODE}*pi*x)", "-dt_size", repr(dt), "-time_end", repr(STEPS * dt), "-method_update", "usl", *method,
               "-history_every", "0", "-output_format", "none", "-output_dir", ".", "-output_name", name)
    energy = check.history(name + ".csv")["total_energy"]
    mean = np.convolve(energy, np.ones(round(2 / MODE / dt)), "valid")
    return -np.log(mean[-1] / mean[0]) / (len(mean) - 1) / 2


def check_walls():
    """With the inertia of each particle apic damps between walls as it does between periodic faces, and by the law."""
    for basis, divisor in INERTIA.items():
        method = ("-method_basis", basis, "-method_transfer", "apic")
        law = (np.pi * MODE / CELLS) ** 4 / divisor
        own, free, uniform = damping("own", "fixed", *method), damping("periodic", "periodic", *method), damping("uniform", "fixed", *method, "-method_wall_inertia", "uniform")
        check.that(abs(own / free - 1) < 0.02, f"{basis}: apic damps by {own:.3e} a step between walls, {free:.3e} between periodic faces (allowed 2 %)")
        check.that(abs(own / law - 1) < 0.1, f"{basis}: {own:.3e} a step, by the law {law:.3e} (allowed 10 %)")
        check.that(uniform > 2 * own, f"{basis}: {uniform:.3e} with the inertia of uniform splines")


def momentum_kept(name, *method):
    """Angular momentum of the particles of a free block after 3 turns over that at the start."""
    check.must("-dim", "2", "-grid_lower", "-.5,-.5", "-grid_upper", ".5,.5", "-grid_cells", "18,18", "-materials", "m", "-material_m_model", "neohookean",
               "-material_m_rho", "1000", "-material_m_E", "3e4", "-material_m_nu", ".3", "-bodies", "b", "-body_b_shape", "box",
               "-body_b_lower", "-.2,-.15", "-body_b_upper", ".2,.15", "-body_b_material", "m", "-body_b_velocity", "0-y,x", "-method_update", "usl", *method,
               "-time_end", repr(6 * np.pi), "-output_every", "100", "-output_dir", ".", "-output_name", name)
    with h5py.File(name + ".h5") as file:
        steps = [file[key]["particles"] for key in sorted(file) if key.startswith("step_")]
        x, v = ([step[field][:] for step in (steps[0], steps[-1])] for field in "xv")
    first, last = ((x[k][:, 0] * v[k][:, 1] - x[k][:, 1] * v[k][:, 0]).sum() for k in range(2))
    return last / first


def check_spin():
    for basis in ("bspline2", "gimp"):
        kept = momentum_kept("spin_" + basis, "-method_basis", basis, "-method_transfer", "afmpm")
        check.that(0.98 <= kept <= 1.001, f"{basis}: afmpm keeps {kept:.4f} of the angular momentum in 3 turns (at least 0.98)")


def error(name, cells, *method):
    """Error of the manufactured solution of options/mms.opts, a part of its size."""
    run = check.must("-options_file", check.scene("mms"), "-grid_cells", f"{cells},{cells}", "-method_update", "usl", *method, "-output_format", "none",
                     "-output_dir", ".", "-output_name", name)
    return float(re.search(r"relative error is (\S+)", run.out)[1])


def check_accuracy():
    """afmpm has the inertia of the full mass matrix: its error is a third of apic's or less; order 1 is apic, bit by bit."""
    for method in (["-method_basis", "bspline3"], ["-method_basis", "gimp", "-method_gimp_update", "stretch"]):
        lumped, full = error("lumped", 16, *method, "-method_transfer", "apic"), error("full", 16, *method, "-method_transfer", "afmpm")
        check.that(full < lumped / 3, f"{method[1]}: error {full:.2e} with afmpm, {lumped:.2e} with apic (at most a third)")
    for update in ("usf", "usl", "musl"):
        common = ["-options_file", check.scene("mms"), "-grid_cells", "8,8", "-time_max_steps", "10", "-method_basis", "bspline2", "-method_update", update]
        digests = [check.must(*common, *transfer, "-output_format", "none", "-output_dir", ".", "-output_name", "order").digest
                   for transfer in (("-method_transfer", "apic"), ("-method_transfer", "afmpm", "-method_order", "1"), ("-method_transfer", "afmpm"))]
        check.that(digests[0] == digests[1] != digests[2], f"{update}: afmpm of order 1 has the bits of apic, order 2 has not")


check.arguments(__doc__, 0)
check_walls()
check_spin()
check_accuracy()
check.end()
