"""Small scenes of one kind each, and cases in files of this folder that name one of them with the options that they change."""
import os
import re
import shlex

import check


def material(**values):
    return {f"material_m_{key}": value for key, value in values.items()}


def body(name, **values):
    return {f"body_{name}_{key}": value for key, value in {"material": "m", **values}.items()}


GROUND = {"dim": 2, "gravity": "0,-9.81", "grid_lower": "0,0", "grid_upper": "20,15", "grid_h": "1,1", "materials": "m", "bodies": "b",
          "bc_ymin_type": "fixed", "bc_xmin_type": "slip", "bc_xmax_type": "slip", "time_end": 1,
          **body("b", shape="box", lower="0,0", upper="20,10")}
UNIT = {"dim": 2, "grid_lower": "0,0", "grid_upper": "1,1", "grid_h": "0.025,0.025", "materials": "m", "time_end": 0.2}
RUBBER = material(model="neohookean", rho=1000, E=1e6, nu=0.3)
SHOT = {**UNIT, "grid_upper": "0.02,0.04", "grid_h": "0.001,0.001", "bodies": "b", "bc_ymin_type": "separate", "bc_xmin_type": "slip",
        "time_end": 5e-5, **body("b", shape="box", lower="0,0.001", upper="0.004,0.03", velocity="0,-200")}
SCENES = {
    "soil": {**GROUND, "initial_stress": "k0",
             **material(model="druckerprager", rho=1800, E=2e7, nu=0.3, friction_angle=30, cohesion=1e4, fit="plane_strain")},
    "clay": {**GROUND, **material(model="vonmises", rho=1800, E=2e7, nu=0.45, **{"yield": 6e5})},
    "water": {**UNIT, "gravity": "0,-9.81", "bodies": "b", "bc_ymin_type": "slip", "bc_xmin_type": "slip", "bc_xmax_type": "slip",
              **body("b", shape="box", lower="0,0", upper="0.5,1"), **material(model="fluid", rho=1000, K=2e6)},
    "metal": {**SHOT, **material(model="vonmises", rho=7850, E=2.1e11, nu=0.3, hardening=1e9, **{"yield": 2.5e8})},
    "shock": {**SHOT, **material(model="johnsoncook", rho=8960, G=47.7e9, c0=3940, hugoniot_slope=1.49, gruneisen=1.96, hardening=2.92e8,
                                 hardening_power=0.31, rate_factor=0.025, specific_heat=383, **{"yield": 9e7})},
    "balls": {**UNIT, "bodies": "a,b", **RUBBER, **body("a", shape="sphere", center="0.25,0.5", radius=0.1, velocity="2,0"),
              **body("b", shape="sphere", center="0.5,0.5", radius=0.1)},
    "beam": {**UNIT, "grid_h": "0.02,0.02", "bodies": "b", **RUBBER, "bc_xmin_type": "fixed", "loads": "l", "load_l_body": "b",
             "load_l_type": "traction", "load_l_face": "xmax", "load_l_value": "0,-100",
             **body("b", shape="box", lower="0,0.4", upper="0.8,0.6")},
    "tool": {**UNIT, "bodies": "b,r", **RUBBER, "bc_ymin_type": "slip", **body("b", shape="box", lower="0.2,0", upper="0.8,0.5"),
             "body_r_shape": "sphere", "body_r_center": "0.5,0.8", "body_r_radius": 0.1, "body_r_rigid": "moving", "body_r_velocity": "0,-1",
             "gravity": "0,-9.81"},
    "jet": {**UNIT, "gravity": "0,-9.81", "bodies": "b,jet", "bc_ymin_type": "slip", "bc_xmin_type": "slip", "bc_xmax_type": "slip",
            **body("b", shape="box", lower="0,0", upper="1,0.2"), **body("jet", shape="box", lower="0,0.5", upper="0.2,0.6", velocity="2,0"),
            "sources": "jet", "source_jet_to": 0.1, **material(model="fluid", rho=1000, K=2e6)},
}


def rows(name):
    """The parts of the lines of a file of cases."""
    with open(os.path.join(check.source, "tests", name), encoding="utf-8") as file:
        for line in file:
            if line.strip() and not line.startswith("#"):
                yield [text.strip() for text in re.split(r"\s::\s", line)]


def changed(arguments):
    """A scene by its name, with the options that follow; none leaves an option out, NONE gives it that value."""
    scene, *words = shlex.split(arguments)
    given = {**SCENES[scene], **{key[1:]: value for key, value in zip(words[::2], words[1::2])}}
    return {key: "none" if value == "NONE" else value for key, value in given.items() if value != "none" or key == "initial_stress"}
