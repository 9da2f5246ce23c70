# SPDX-License-Identifier: MIT
"""The programs in a wheel: `ectwin` and the others as console commands.

    ectwin.programs.path("ectwin-conform")      the program's file, or None if this installation lacks it
"""

import os
import sys
from typing import NoReturn, Optional

__all__ = ["path"]

_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin")


def path(name: str) -> Optional[str]:
    """The file of a program next to this module; None: the module was installed without the program."""
    file = os.path.join(_FOLDER, name)
    return file if os.access(file, os.X_OK) else None


def main() -> NoReturn:
    """Executes the program with the name of this process."""
    name = os.path.basename(sys.argv[0])
    file = path(name)
    if file is None:
        masters = "ectwin was built without SOEM, which this program needs: run tools/bootstrap.sh run, then pip install again"
        sys.exit(f"{name}: {masters}")
    os.execv(file, [name, *sys.argv[1:]])
