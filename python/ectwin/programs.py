# SPDX-License-Identifier: MIT
"""The programs that a wheel carries: `ectwin` and the others as console commands.

    ectwin.programs.path("ectwin-conform")      the program's file, or None when this installation has none
"""

import os
import sys
from typing import NoReturn, Optional

__all__ = ["path"]

_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin")


def path(name: str) -> Optional[str]:
    """The file of a program beside this module; None: the module was installed without it."""
    file = os.path.join(_FOLDER, name)
    return file if os.access(file, os.X_OK) else None


def main() -> NoReturn:
    """Becomes the program whose name this process was called by."""
    name = os.path.basename(sys.argv[0])
    file = path(name)
    if file is None:
        masters = "ectwin was built without SOEM, which this program needs: run tools/bootstrap.sh run, then pip install again"
        sys.exit(f"{name}: {masters}")
    os.execv(file, [name, *sys.argv[1:]])
