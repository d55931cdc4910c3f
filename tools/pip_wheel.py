"""What pip calls to install the module (PEP 517, by pyproject.toml): a wheel with lab/pebble_mpm.py, and the program ./pebble if it
is there, as a script, so that the module finds it. It needs nothing but Python's own library."""
import base64
import hashlib
import os
import re
import sysconfig
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
NAME = "pebble_mpm"
NEEDS = ("numpy", "h5py")


def read(name):
    with open(os.path.join(ROOT, name), "rb") as file:
        return file.read()


def version():
    return re.search(r"^version: *\"?([\d.]+)", read("CITATION.cff").decode(), re.M)[1]


def write(path, module, program):
    """Writes a wheel: the module is a file {name: content}, which are listed with their checksums."""
    info = f"{NAME}-{version()}.dist-info"
    tag = f"py3-none-{re.sub('[-.]', '_', sysconfig.get_platform()) if program else 'any'}"
    files = dict(module)
    if program:
        files[f"{NAME}-{version()}.data/scripts/pebble"] = program
    files[f"{info}/METADATA"] = "\n".join(
        ["Metadata-Version: 2.1", "Name: pebble-mpm", f"Version: {version()}", "Summary: Pebble, a Material Point Method program, from Python",
         "Requires-Python: >=3.11", *(f"Requires-Dist: {name}" for name in NEEDS), ""]).encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: pebble\nRoot-Is-Purelib: true\nTag: {tag}\n".encode()
    files[f"{info}/LICENSE"] = read("LICENSE")
    sums = {name: base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode() for name, content in files.items()}
    files[f"{info}/RECORD"] = "".join([*(f"{name},sha256={total},{len(files[name])}\n" for name, total in sums.items()), f"{info}/RECORD,,\n"]).encode()
    name = f"{NAME}-{version()}-{tag}.whl"
    with zipfile.ZipFile(os.path.join(path, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for file, content in files.items():
            entry = zipfile.ZipInfo(file)
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, (0o100755 if "/scripts/" in file else 0o100644) << 16
            wheel.writestr(entry, content)
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    there = os.access(os.path.join(ROOT, "pebble"), os.X_OK)
    return write(wheel_directory, {f"{NAME}.py": read(f"lab/{NAME}.py")}, read("pebble") if there else None)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """For pip install -e: the module of this folder, which finds the program of this folder."""
    return write(wheel_directory, {f"{NAME}.pth": os.path.join(ROOT, "lab").encode() + b"\n"}, None)
