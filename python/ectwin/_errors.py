# SPDX-License-Identifier: MIT
"""The errors of the module."""


class Error(Exception):
    """No such twin, no reply of the twin, or the twin has ended."""


class Refused(Error):
    """The twin refuses a request; the message is the reason."""
