#!/usr/bin/env python3
"""Downward only: which folder may include which, and where each vendor's header has its home (DESIGN.md section 6).

check_layering.py              the tree below the project's folder; status 1 and one line for each forbidden include
check_layering.py --self-test  the rules themselves, on made-up includes that must be caught
"""
import pathlib
import re
import sys

TYPES = {"core/base", "core/geometry", "core/image", "core/scene"}
STAGES = {"core/seed", "core/mvs", "core/match", "core/adjust", "core/validate", "core/drift"}
CORE = TYPES | STAGES | {"core/rig"}
DEVICE_DRIVERS = {"drivers/" + name for name in ("genicam", "usb", "linuxcnc", "grbl", "arm", "replay", "sim")}
# folder -> folders of this project that its files may include (its own is always allowed)
MAY_INCLUDE = {
    "core/base": set(),
    "core/geometry": {"core/base"},
    "core/image": {"core/base", "core/geometry"},
    "core/scene": {"core/base", "core/geometry", "core/image"},
    "core/rig": TYPES,
    **{stage: TYPES | {"core/rig"} for stage in STAGES},
    "drivers": CORE | DEVICE_DRIVERS,  # the registry names them all
    **{driver: CORE | {"drivers"} for driver in DEVICE_DRIVERS},
    "drivers/genicam": CORE | {"drivers", "drivers/usb"},  # Aravis may open USB cameras only after drivers/usb said so
    "drivers/sim": CORE | {"drivers", "sim_fixtures"},
    "drivers/acquire": CORE | {"drivers"},
    "config": CORE | {"config/formats"},
    "config/formats": TYPES,
    "sim_fixtures": TYPES,
    "daemon": CORE | {"drivers", "drivers/acquire", "config", "config/formats"},
    "daemon/cli": CORE | {"drivers", "drivers/acquire", "config", "config/formats", "daemon", "sim_fixtures"},
    "tests": CORE | DEVICE_DRIVERS
    | {"drivers", "drivers/acquire", "config", "config/formats", "daemon", "daemon/cli", "sim_fixtures", "tests/support"},
}
# vendor header -> folders that may include it
VENDOR_HOMES = {
    r"ceres/tiny_solver": {"core/rig", "core/adjust", "core/seed", "core/match", "core/validate"},
    r"ceres/(?!tiny_solver)": {"core/rig", "core/adjust", "core/seed"},
    r"embree3/": {"sim_fixtures"},
    r"apriltag": {"core/seed"},
    r"arv\.h": {"drivers/genicam"},
    r"libusb": {"drivers/usb"},
    r"umockdev": {"sim_fixtures"},
    r"(sqlite3|SQLiteCpp)": {"config"},
    r"httplib": {"daemon"},
    r"systemd/": {"daemon/rigcald"},
    r"CLI/": {"daemon/cli", "daemon/rigcald"},
    r"toml\+\+": {"config"},
    r"hpdf": {"config"},
    r"nlohmann/": {"config", "config/formats", "daemon", "daemon/cli", "sim_fixtures"},
}
INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.M)


def home(path):
    """The longest folder with a rule that holds `path`; None outside the layers."""
    parts = pathlib.PurePosixPath(path).parts[:-1]
    for length in range(len(parts), 0, -1):
        folder = "/".join(parts[:length])
        if folder in MAY_INCLUDE or folder in ("tests/support",):
            return folder
    return None


def complaints(path, text):
    own = home(path)
    if own is None:
        return []
    allowed = MAY_INCLUDE.get(own, MAY_INCLUDE["tests"])
    found = []
    for include in INCLUDE.findall(text):
        target = home(include)
        if target and target != own and target not in allowed and not (own.startswith("tests") and target.startswith("tests")):
            found.append(f"{path}: {own} must not include {include}")
        if not own.startswith("tests"):
            for pattern, homes in VENDOR_HOMES.items():
                if re.match(pattern, include) and own not in homes and str(pathlib.PurePosixPath(path).parent) not in homes:
                    found.append(f"{path}: {include} has its home in {', '.join(sorted(homes))}")
    return found


def self_test():
    caught = [
        ("core/mvs/a.cpp", '#include "core/match/match.h"'),
        ("core/base/a.cpp", '#include "core/scene/patch.h"'),
        ("core/adjust/a.cpp", '#include "config/export.h"'),
        ("core/mvs/a.cpp", "#include <ceres/ceres.h>"),
        ("config/a.cpp", '#include "daemon/calibration_run.h"'),
        ("core/scene/a.h", '#include "sim_fixtures/studio.h"'),
        ("config/formats/a.cpp", '#include "config/read_file.h"'),
        ("drivers/replay/a.cpp", '#include "sim_fixtures/studio.h"'),
        ("drivers/replay/a.cpp", '#include "config/recording_file.h"'),
        ("drivers/grbl/a.cpp", '#include "drivers/linuxcnc/linuxcnc.h"'),
        ("drivers/acquire/a.cpp", '#include "drivers/sim/sim_driver.h"'),
        ("daemon/a.cpp", '#include "drivers/replay/replay_driver.h"'),
    ]
    fine = [
        ("core/mvs/a.cpp", '#include "core/scene/patch.h"'),
        ("core/adjust/a.cpp", "#include <ceres/ceres.h>"),
        ("daemon/cli/a.cpp", '#include "daemon/calibration_run.h"'),
        ("tests/mvs/a.cpp", '#include "sim_fixtures/studio.h"'),
        ("drivers/sim/a.cpp", '#include "sim_fixtures/studio.h"'),
        ("drivers/grbl/a.cpp", '#include "drivers/positioner_device.h"'),
        ("drivers/genicam/a.cpp", '#include "drivers/usb/usb_device.h"'),
        ("daemon/a.cpp", '#include "drivers/acquire/acquire.h"'),
    ]
    wrong = [case for case in caught if not complaints(*case)] + [case for case in fine if complaints(*case)]
    for path, text in wrong:
        print(f"rule broken: {path} with {text}")
    return len(wrong)


def main():
    if "--self-test" in sys.argv:
        return 1 if self_test() else 0
    root = pathlib.Path(__file__).resolve().parents[2]
    found = []
    for top in ("core", "config", "daemon", "drivers", "sim_fixtures", "tests"):
        for path in sorted((root / top).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                found += complaints(path.relative_to(root).as_posix(), path.read_text())
    print("\n".join(found) if found else "layering: no forbidden include")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
