"""How long a scene stays loaded at a replica: until it is replaced, or until others that were used later need its memory.

Requests about a scene come at random at a rate. Least recently used goes first, so a scene is dropped if no request comes for the
replica's *patience*: the time in which others fill the memory (Che's approximation). What follows is exact for that model.
"""
import numpy as np

LONGEST_S = 1e9
_STEPS = 40  # of bisection, on the logarithm of the patience


def stay(rate, patience_s, life_s):
    """The chance that a scene is still loaded when its next request comes; also the share of time for which it is loaded."""
    total = rate + 1 / life_s
    return rate / total * -np.expm1(-total * patience_s)


def built_share(chance, reach):
    """The mean share of trees that is built when a request ends. The k-th request of a stay leaves 1 - (1 - reach)^k."""
    return reach / (1 - (1 - reach) * chance)


def missing_share(chance, reach):
    """The mean part of what a request needs that is not built when it comes."""
    return (1 - chance) / (1 - (1 - reach) * chance)


def patience(rates, replicas, count, bytes_of, budget_bytes, life_s):
    """For each of `count` replicas, in seconds. rates: of pairs of a scene and a replica; replicas: theirs; bytes_of: from the chances
    of all pairs, their mean bytes while loaded."""
    low, high = np.full(count, -6.0), np.full(count, np.log10(LONGEST_S))
    for _ in range(_STEPS):
        middle = (low + high) / 2
        chance = stay(rates, (10 ** middle)[replicas], life_s)
        held = np.bincount(replicas, chance * bytes_of(chance), count)
        fits = held <= budget_bytes
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return 10 ** low
