# SPDX-License-Identifier: MIT
"""EtherCAT device twins from Python: start some, run masters beside them, get, set and watch their signals.

    import ectwin
    with ectwin.start("fzm1") as twin:                       # in a private network, without root
        twin.set({"data1": 1.5})
        twin.run(["./my_master", twin.interface], check=True)
        print(twin.get("ecat.state"), twin.stats()["frames"])

Chain is a bus of twins inside this process (docs/API.md). docs/PYTHON.md is the manual, docs/CONTROL.md the protocol.
No dependencies; Python 3.8 or newer, Linux.
"""

from ._control import Change, Signal, Watch
from ._errors import Error, Refused
from ._plant import Plant, camera
from ._twin import Twin, connect, ps, start
from .chain import Chain, Reply

__all__ = ["Chain", "Change", "Error", "Plant", "Refused", "Reply", "Signal", "Twin", "Watch", "camera", "connect", "ps", "start"]
