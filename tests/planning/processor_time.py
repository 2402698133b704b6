"""The processor time that processes have used, all threads together."""
import os
import pathlib
import time


def used_s(pids):
    """Of processes that run, to the nanosecond."""
    return sum(time.clock_gettime(((~pid) << 3) | 2) for pid in pids)


def tree_used_s(pid):
    """Of a process and its children, those that have ended (to a clock tick) as well."""
    live = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    ended = (int(fields[13]) + int(fields[14])) / os.sysconf("SC_CLK_TCK")  # cutime, cstime
    return used_s([pid]) + ended + sum(map(_used_if_there_s, map(int, live)))


def _used_if_there_s(pid):
    try:
        return used_s([pid])
    except OSError:
        return 0.0
