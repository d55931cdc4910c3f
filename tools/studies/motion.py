"""What methods do to a body that spins or drifts for long: one row a method and case of docs/data/motion.csv.

spin      a block of 0.4 x 0.3 m, h = 1/18 m, spins freely at 1 rad/s: angular momentum over that at the start
disk      a disk of R/h = 4, softer
drift     a bar of 32 cells drifts over cells at 0.13 c for 40,000 steps of C = 0.4, perturbed by 1e-6: its strain energy at
          the end over its kinetic energy. The perturbation's own is 1e-10 of it, and stays so where the method is stable.

sand      options/column.opts: how far the sand runs out, m (99.5 % of it), with two lengths of the step
dam       options/dambreak.opts: where the front is at the end, m (99.5 % of the water), and the energy that is missing of what
          gravity did, with two lengths of the step

Angular momentum is that of the particles' velocities, and with the affine part (APIC) where the history has it.
"""
import math

import numpy as np
from problems import positions, reach

TURN = 2 * math.pi
SOLID = "-materials m -material_m_model neohookean -material_m_rho 1000 -material_m_nu .3 -bodies b -body_b_material m"
CASES = {
    "spin": f"-dim 2 -grid_lower -.5,-.5 -grid_upper .5,.5 -grid_cells 18,18 {SOLID} -material_m_E 3e4 -body_b_shape box -body_b_lower -.2,-.15 -body_b_upper .2,.15 "
            f"-body_b_velocity 0-y,x -time_end {100 * TURN!r} -output_every {TURN!r} -output_fields mass,velocity -history_every {TURN!r}",
    "disk": f"-dim 2 -grid_lower -.5,-.5 -grid_upper .5,.5 -grid_cells 16,16 {SOLID} -material_m_E 1e4 -body_b_shape sphere -body_b_center 0,0 -body_b_radius .25 "
            f"-body_b_velocity 0-y,x -time_end {100 * TURN!r} -output_every {TURN!r} -output_fields mass,velocity -history_every {TURN!r}",
    "drift": "-dim 1 -grid_lower 0 -grid_upper 1 -grid_cells 50 -bc_xmin_type periodic -bc_xmax_type periodic -materials m -material_m_model elastic -material_m_rho 1 "
             "-material_m_E 1 -material_m_nu 0 -bodies b -body_b_shape box -body_b_lower .18 -body_b_upper .82 -body_b_material m "
             "-body_b_velocity 0.13+1e-6*(sin(pi*(x-.5)/.64)+sin(21*pi*(x-.5)/.64)) -time_end 283 -output_format none -history_every 283",
    "sand": "-output_every 1.8 -output_fields mass",
    "dam": "-check_energy 0 -output_every 0.7 -output_fields mass -history_every 0.7",
}
SCENES = {"sand": "column", "dam": "dambreak"}  # files of options/
STEPS = {"sand": (0.4, 0.1), "dam": (0.4, 0.1)}  # -dt_cfl, where it is not the method's own
COLUMNS = ["case", "method", "options", "cfl", "status", "turns3", "turns30", "turns100", "with_affine3", "with_affine100", "front", "energy", "why"]
KEY = ["case", "method", "options", "cfl"]


def evaluate(case, run):
    """The values of a run that ended, or what there is of one that was stopped."""
    row = dict.fromkeys(COLUMNS[5:], "")
    if case == "drift":
        row["energy"] = f"{run.history('strain_energy')[-1] / run.history('kinetic_energy')[0]:.3g}"
        return row
    if case in STEPS and run.status:
        return row
    t, x, v, m = positions(run.path(".h5"))
    if case in STEPS:
        row["front"] = f"{reach(x[-1][:, 0], m) - (case == 'sand'):.4f}"
        if case == "dam":
            row["energy"] = f"{1 - run.history('total_energy')[-1] / run.history('external_work')[-1]:.4f}"
        return row
    L = (m * (x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0])).sum(1)
    for turns in 3, 30, 100:
        k = np.abs(t - turns * TURN).argmin()
        if abs(t[k] - turns * TURN) < 0.1 * TURN:
            row[f"turns{turns}"] = f"{L[k] / L[0]:.4f}"
    names = [name for name in run.columns() if name.startswith("angular_momentum")]
    if names:
        t, L = np.array(run.history("time")), np.array(run.history(names[-1]))
        for turns in 3, 100:
            row[f"with_affine{turns}"] = f"{L[np.abs(t - turns * TURN).argmin()] / L[0]:.4f}"
    row["energy"] = f"{run.history('total_energy')[-1] / run.history('total_energy')[0]:.4f}"
    return row
