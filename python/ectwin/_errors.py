# SPDX-License-Identifier: MIT
"""The errors of the module."""


class Error(Exception):
    """There is no twin, it does not answer, or it has ended."""


class Refused(Error):
    """The twin refuses a request; the message is the reason."""
