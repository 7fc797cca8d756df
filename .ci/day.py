#!/usr/bin/env python3
"""Which sample of long checks runs: another one each day.

As a command it prints the number of the day, for scripts of the shell.
"""
import os
import time


def number():
    """The number in ENCSPEC_SAMPLE, otherwise that of the day; None for `all`."""
    setting = os.environ.get("ENCSPEC_SAMPLE") or str(int(time.time() // 86400))
    return None if setting == "all" else int(setting)


if __name__ == "__main__":
    print(number() or 0)
