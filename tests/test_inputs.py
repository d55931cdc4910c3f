"""How many of the inputs that other codes ship (docs/data/inputs.csv) can be set up as they are meant: those of which the program
has every feature that they need beyond bodies, elastic and plastic laws, fluids, walls and gravity. docs/compare.md has the number.

usage: test_inputs.py PEBBLE SOURCE MPIEXEC
"""
import re

import check

# The features that the program has, each with an option, and one of its values, without which it would not have it. Mohr and
# Coulomb's law is not here: Drucker-Prager agrees with it in one kind of deformation only.
BUILT = {
    "contact-friction": ("contact_<c>_mu", ""), "contact-separation": ("contact_mu", ""), "rigid-obstacle": ("body_<b>_rigid", "fixed"), "inclined-wall": ("body_<b>_rigid", "fixed"),
    "rigid-moving": ("body_<b>_rigid", "moving"), "rigid-dynamic": ("body_<b>_rigid", "free"), "bc-inside": ("body_<b>_tied", ""), "nodal-force": ("load_<l>_where", ""),
    "load-inside": ("load_<l>_type", "force"), "torque-load": ("load_<l>_type", "torque"), "implicit-static": ("method_time", "static"), "axisymmetric": ("geometry", "axisymmetric"),
    "source": ("sources", ""), "stages": ("stages", ""), "excavation": ("remove", "")}
TABLE = "time-table"  # table() in formulas, which is no option

check.arguments(__doc__, 0)
said = check.must("-help").out
for feature, (option, value) in BUILT.items():
    line = re.search(rf"^ *-{re.escape(option)}\b.*$", said, re.M)
    check.that(line and value in line.group(0), f"{feature}: -{option} {value}")
rows = check.rows(check.source + "/docs/data/inputs.csv")
needs = [set(row["needs"].split()) for row in rows]
meant = sum(need <= {*BUILT, TABLE} for need in needs)
without = sum(not need for need in needs)
contact = sum(need <= {feature for feature, (option, _) in BUILT.items() if re.match("contact|body|load", option)} for need in needs)
text = re.sub(r"\s+", " ", check.content(check.source + "/docs/compare.md").decode())
told = re.search(r"(\d+) inputs that sixteen codes ship, (\d+) can be set up as they are meant .*? (\d+) of these need contact, rigid bodies or forces on parts of a body", text)
check.that(told and tuple(map(int, told.groups())) == (len(rows), meant, contact - without),
           f"of {len(rows)} inputs {meant} can be set up as they are meant, {contact} without statics, revolution, sources and stages, {without} before; the document says {told and told.groups()}")
check.end()
