"""Runs other programs, and says what they said if they fail."""

import os
import subprocess


class Failure(Exception):
    """Ends the command with this message."""


def output_of(*words):
    """What a program printed. The environment's own search paths of libraries are left out: users do not have them."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("LD_")}
    try:
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False,
                              env={**environment, "LC_ALL": "C.UTF-8"})
    except OSError as error:
        raise Failure(f"{words[0]}: {error.strerror}") from error
    if done.returncode != 0:
        said = (done.stderr or done.stdout).strip()
        raise Failure(f"{' '.join(map(str, words))}: exit code {done.returncode}: {said[-2000:]}")
    return done.stdout
